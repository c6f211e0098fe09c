#pragma once

#include "../simd.hpp"
#include "cloud_kernels.hpp"

namespace consimd::detail {

template <typename Arch>
inline Vec3<Arch> load_unaligned(const float* const points[3], std::size_t j) {
  return {Batch<Arch>::load_unaligned(points[0] + j), Batch<Arch>::load_unaligned(points[1] + j),
          Batch<Arch>::load_unaligned(points[2] + j)};
}

/// The lowest `count` bits, as many as a register has lanes at most.
template <typename Arch>
inline std::uint64_t lowest_bits(std::size_t count) {
  return (std::uint64_t{1} << (count < kWidth<Arch> ? count : kWidth<Arch>)) - 1;
}

/// Indices j .. j + width - 1 of a list of n, the last one again beyond its end.
template <typename Arch>
class IndexBlock {
 public:
  IndexBlock(const std::uint32_t* indices, std::size_t n, std::size_t j) : block_(indices + j) {
    if (n - j >= kWidth<Arch>) return;
    for (std::size_t l = 0; l < kWidth<Arch>; ++l) filled_[l] = indices[l < n - j ? j + l : n - 1];
    block_ = filled_;
  }

  Vec3<Arch> points(const float* const rows[3]) const {
    return {gather(rows[0], block_, Arch{}), gather(rows[1], block_, Arch{}), gather(rows[2], block_, Arch{})};
  }

 private:
  const std::uint32_t* block_;
  std::uint32_t filled_[kWidth<Arch>];
};

template <typename Arch>
std::size_t neighbours_within(const RawPoints& cloud, const float query[3], const PointRun* runs, std::size_t n,
                              float radius, std::uint32_t* indices, float* squared) {
  const Vec3<Arch> q{Batch<Arch>(query[0]), Batch<Arch>(query[1]), Batch<Arch>(query[2])};
  const Batch<Arch> limit(radius * radius);
  std::size_t count = 0;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::uint32_t i = runs[r].first; i < runs[r].last; i += static_cast<std::uint32_t>(kWidth<Arch>)) {
      const Vec3<Arch> offset = load_unaligned<Arch>(cloud.points, i) - q;
      const Batch<Arch> distance = dot(offset, offset);
      const std::uint64_t bits = bitmask(distance <= limit) & lowest_bits<Arch>(runs[r].last - i);
      store_chosen(distance, i, bits, squared + count, indices + count);
      count += popcount<Arch>(bits);
    }
  }
  return count;
}

/// The nearest points found so far, as in scalar.cpp.
template <typename Arch>
struct NearestList {
  std::size_t most;
  std::uint32_t* indices;
  float* squared;
  std::size_t count = 0;

  bool full() const { return count == most; }

  void enter(std::uint32_t index, float distance) {
    if (full() && !nearer(index, distance, most - 1)) return;
    std::size_t rank = full() ? most - 1 : count++;
    for (; rank > 0 && nearer(index, distance, rank - 1); --rank) {
      squared[rank] = squared[rank - 1];
      indices[rank] = indices[rank - 1];
    }
    squared[rank] = distance;
    indices[rank] = index;
  }

 private:
  bool nearer(std::uint32_t index, float distance, std::size_t rank) const {
    return distance < squared[rank] || (distance == squared[rank] && index < indices[rank]);
  }
};

template <typename Arch>
std::size_t nearest_within(const RawPoints& cloud, const float query[3], const PointRun* runs, std::size_t n,
                           float radius, std::size_t most, std::uint32_t* indices, float* squared) {
  const Vec3<Arch> q{Batch<Arch>(query[0]), Batch<Arch>(query[1]), Batch<Arch>(query[2])};
  NearestList<Arch> nearest{most, indices, squared};
  Batch<Arch> limit(radius * radius);
  alignas(64) float lanes[kWidth<Arch>];
  for (std::size_t r = 0; r < n; ++r) {
    for (std::uint32_t i = runs[r].first; i < runs[r].last; i += static_cast<std::uint32_t>(kWidth<Arch>)) {
      const Vec3<Arch> offset = load_unaligned<Arch>(cloud.points, i) - q;
      const Batch<Arch> distance = dot(offset, offset);
      // As near as the last of a full list counts: its index may be the higher one.
      std::uint64_t bits = bitmask(distance <= limit) & lowest_bits<Arch>(runs[r].last - i);
      if (bits == 0) continue;
      distance.store_aligned(lanes);
      for (; bits != 0; bits &= bits - 1) {
        const auto lane = static_cast<std::uint32_t>(__builtin_ctzll(bits));
        nearest.enter(i + lane, lanes[lane]);
      }
      if (nearest.full()) limit = Batch<Arch>(squared[most - 1]);
    }
  }
  return nearest.count;
}

template <typename Arch>
void neighbourhood_scatter(const RawPoints& cloud, const float centre[3], const std::uint32_t* indices, std::size_t n,
                           float unit, float scatter[6]) {
  const Vec3<Arch> c{Batch<Arch>(centre[0]), Batch<Arch>(centre[1]), Batch<Arch>(centre[2])};
  const Batch<Arch> shrink(1.0f / unit);
  InterleavedSum<Arch> x, y, z, xx, xy, xz, yy, yz, zz;
  for (std::size_t j = 0; j < n; j += kWidth<Arch>) {
    const Mask<Arch> present = mask_of(lowest_bits<Arch>(n - j), Arch{});
    const Vec3<Arch> all = shrink * (IndexBlock<Arch>(indices, n, j).points(cloud.points) - c);
    const Vec3<Arch> d{keep<Arch>(present, all.x), keep<Arch>(present, all.y), keep<Arch>(present, all.z)};
    x.add(j, d.x);
    y.add(j, d.y);
    z.add(j, d.z);
    xx.add(j, d.x * d.x);
    xy.add(j, d.x * d.y);
    xz.add(j, d.x * d.z);
    yy.add(j, d.y * d.y);
    yz.add(j, d.y * d.z);
    zz.add(j, d.z * d.z);
  }
  const float share = 1.0f / static_cast<float>(n);
  const float sum[3] = {x.total(), y.total(), z.total()};
  const float mean[3] = {share * sum[0], share * sum[1], share * sum[2]};
  scatter[0] = xx.total() - sum[0] * mean[0];
  scatter[1] = xy.total() - sum[0] * mean[1];
  scatter[2] = xz.total() - sum[0] * mean[2];
  scatter[3] = yy.total() - sum[1] * mean[1];
  scatter[4] = yz.total() - sum[1] * mean[2];
  scatter[5] = zz.total() - sum[2] * mean[2];
}

/// As in scalar.cpp, a matrix in each lane.
template <typename Arch>
struct Diagonalisation {
  Batch<Arch> diagonal[3];
  Batch<Arch> beside[3];
  Batch<Arch> columns[3][3];

  void rotate(int p, int q, int r) {
    const Batch<Arch> zero(0.0f);
    const Batch<Arch> one(1.0f);
    const Batch<Arch> e = beside[r] + beside[r];
    const Batch<Arch> d = diagonal[q] - diagonal[p];
    const Batch<Arch> h = xsimd::abs(d) + square_root(d * d + e * e);
    const Batch<Arch> t = xsimd::select(h > zero, divide(xsimd::select(d < zero, zero - e, e), h), zero);
    const Batch<Arch> c = divide(one, square_root(t * t + one));
    const Batch<Arch> s = t * c;
    diagonal[p] = diagonal[p] - t * beside[r];
    diagonal[q] = diagonal[q] + t * beside[r];
    beside[r] = zero;
    const Batch<Arch> rp = beside[q];
    const Batch<Arch> rq = beside[p];
    beside[q] = c * rp - s * rq;
    beside[p] = s * rp + c * rq;
    for (int k = 0; k < 3; ++k) {
      const Batch<Arch> of_p = columns[p][k];
      const Batch<Arch> of_q = columns[q][k];
      columns[p][k] = c * of_p - s * of_q;
      columns[q][k] = s * of_p + c * of_q;
    }
  }
};

template <typename Arch>
void principal_axes(const float* const scatter[6], std::size_t n, float* const axes[3], float* const values[3]) {
  constexpr int kSweeps = 4;
  const auto select = [](const Mask<Arch>& mask, const Batch<Arch>& a, const Batch<Arch>& b) {
    return xsimd::select(mask, a, b);
  };
  const Batch<Arch> zero(0.0f);
  const Batch<Arch> one(1.0f);
  for (std::size_t i = 0; i < n; i += kWidth<Arch>) {
    const auto entry = [&](int k) { return Batch<Arch>::load_aligned(scatter[k] + i); };
    Diagonalisation<Arch> m{{entry(0), entry(3), entry(5)},
                            {entry(4), entry(2), entry(1)},
                            {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}}};
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      m.rotate(0, 1, 2);
      m.rotate(0, 2, 1);
      m.rotate(1, 2, 0);
    }
    const Batch<Arch>* d = m.diagonal;
    const Mask<Arch> second_below_first = d[1] < d[0];
    const Batch<Arch> low = select(second_below_first, d[1], d[0]);
    const Batch<Arch> high = select(second_below_first, d[0], d[1]);
    const Mask<Arch> third_lowest = d[2] < low;
    for (int k = 0; k < 3; ++k) {
      const Batch<Arch> of_low = select(second_below_first, m.columns[1][k], m.columns[0][k]);
      select(third_lowest, m.columns[2][k], of_low).store_aligned(axes[k] + i);
    }
    const Mask<Arch> third_highest = high < d[2];
    select(third_lowest, d[2], low).store_aligned(values[0] + i);
    select(third_lowest, low, select(third_highest, high, d[2])).store_aligned(values[1] + i);
    select(third_highest, d[2], high).store_aligned(values[2] + i);
  }
}

}  // namespace consimd::detail
