#pragma once

#include "kernel_table.hpp"
#include "simd.hpp"

namespace consimd::detail {

template <typename Arch>
struct Triangles {
  Vec3<Arch> x, y, z;
  Batch<Arch> length, a, b;
  Mask<Arch> spans_plane;

  Triangles(const Vec3<Arch>& p1, const Vec3<Arch>& p2, const Vec3<Arch>& p3) {
    const Vec3<Arch> e1 = p2 - p1;
    const Vec3<Arch> e2 = p3 - p1;
    const Vec3<Arch> normal = cross(e1, e2);
    const Batch<Arch> squared_length = dot(e1, e1);
    const Batch<Arch> squared_normal = dot(normal, normal);
    const Batch<Arch> normal_length = square_root(squared_normal);
    length = square_root(squared_length);
    x = divide(Batch<Arch>(1.0f), length) * e1;
    z = divide(Batch<Arch>(1.0f), normal_length) * normal;
    y = cross(z, x);
    a = dot(e2, x);
    b = divide(normal_length, length);
    spans_plane = squared_normal > 1e-10f * (squared_length * dot(e2, e2));
  }
};

/// The points of one corner of `count` triangles, and lanes of the last triangle from there on.
template <typename Arch>
inline Vec3<Arch> gather(const float* const points[3], const IndexTriple* triples, std::size_t count,
                         std::uint32_t IndexTriple::*corner) {
  alignas(64) float lanes[3][kWidth<Arch>];
  for (std::size_t l = 0; l < kWidth<Arch>; ++l) {
    const std::uint32_t index = triples[l < count ? l : count - 1].*corner;
    for (int axis = 0; axis < 3; ++axis) lanes[axis][l] = points[axis][index];
  }
  const float* const rows[3] = {lanes[0], lanes[1], lanes[2]};
  return load<Arch>(rows, 0);
}

template <typename Arch>
void three_point_fits(const RawView& view, const IndexTriple* triples, std::size_t n, WorkingPose* poses) {
  constexpr float kThird = 1.0f / 3.0f;
  for (std::size_t begin = 0; begin < n; begin += kWidth<Arch>) {
    const std::size_t count = n - begin < kWidth<Arch> ? n - begin : kWidth<Arch>;
    const auto corner = [&](const float* const points[3], std::uint32_t IndexTriple::*which) {
      return gather<Arch>(points, triples + begin, count, which);
    };
    const Vec3<Arch> p1 = corner(view.source, &IndexTriple::first);
    const Vec3<Arch> p2 = corner(view.source, &IndexTriple::second);
    const Vec3<Arch> p3 = corner(view.source, &IndexTriple::third);
    const Vec3<Arch> q1 = corner(view.target, &IndexTriple::first);
    const Vec3<Arch> q2 = corner(view.target, &IndexTriple::second);
    const Vec3<Arch> q3 = corner(view.target, &IndexTriple::third);
    const Triangles<Arch> s(p1, p2, p3);
    const Triangles<Arch> t(q1, q2, q3);

    const Batch<Arch> dots =
        s.length * t.length + s.a * t.a + s.b * t.b - kThird * ((s.length + s.a) * (t.length + t.a) + s.b * t.b);
    const Batch<Arch> crosses = s.a * t.b - s.b * t.a - kThird * ((s.length + s.a) * t.b - s.b * (t.length + t.a));
    const Batch<Arch> norm = square_root(dots * dots + crosses * crosses);
    const Batch<Arch> cosine = divide(dots, norm);
    const Batch<Arch> sine = divide(crosses, norm);

    const Vec3<Arch> x = cosine * t.x + sine * t.y;
    const Vec3<Arch> y = cosine * t.y - sine * t.x;
    const Vec3<Arch> row0 = x.x * s.x + y.x * s.y + t.z.x * s.z;
    const Vec3<Arch> row1 = x.y * s.x + y.y * s.y + t.z.y * s.z;
    const Vec3<Arch> row2 = x.z * s.x + y.z * s.y + t.z.z * s.z;
    const Batch<Arch> third(kThird);
    const Vec3<Arch> p = third * (p1 + p2 + p3);
    const Vec3<Arch> q = third * (q1 + q2 + q3);
    const Batch<Arch> entries[12] = {row0.x,
                                     row0.y,
                                     row0.z,
                                     row1.x,
                                     row1.y,
                                     row1.z,
                                     row2.x,
                                     row2.y,
                                     row2.z,
                                     q.x - dot(row0, p),
                                     q.y - dot(row1, p),
                                     q.z - dot(row2, p)};

    const Mask<Arch> valid = s.spans_plane & t.spans_plane & (norm > Batch<Arch>(0.0f));
    const Batch<Arch> nan(__builtin_nanf(""));
    alignas(64) float lanes[12][kWidth<Arch>];
    for (int k = 0; k < 12; ++k) xsimd::select(valid, entries[k], nan).store_aligned(lanes[k]);
    for (std::size_t l = 0; l < count; ++l) {
      for (int k = 0; k < 9; ++k) poses[begin + l].rotation[k] = lanes[k][l];
      for (int k = 0; k < 3; ++k) poses[begin + l].translation[k] = lanes[9 + k][l];
    }
  }
}

}  // namespace consimd::detail
