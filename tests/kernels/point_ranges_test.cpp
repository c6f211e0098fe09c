#include <consimd/kernels/point_ranges.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace consimd::test {
namespace {

/// As the Point Cloud Library lays out its smallest point: 16 bytes, aligned to 16.
struct alignas(16) PaddedPoint {
  union {
    float data[4];
    struct {
      float x;
      float y;
      float z;
    };
  };
};

/// What a lidar driver fills: the coordinates are not first.
struct LidarPoint {
  double time;
  std::uint32_t ring;
  float intensity;
  float x, y, z;
  std::uint8_t label;
};

struct DoublePoint {
  double x, y, z;
};

struct InterleavedPoint {
  float x, x_sigma, y, y_sigma, z, z_sigma;
};

struct UnevenPoint {
  float x, y, time, z;
};

template <typename Point>
std::vector<Point> numbered_points(std::size_t n) {
  std::vector<Point> points(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto first = 10.0f * static_cast<float>(i);
    points[i].x = first;
    points[i].y = first + 1;
    points[i].z = first + 2;
  }
  return points;
}

template <typename T>
void expect_numbered(const PointSpan<T>& span, std::size_t n, const void* data) {
  EXPECT_EQ(span.data, data);
  ASSERT_EQ(span.size, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(span(i, c), static_cast<T>(10 * i + c));
  }
}

TEST(PointRanges, TakeStructsOfAnyLayoutInPlace) {
  const auto padded = numbered_points<PaddedPoint>(5);
  static_assert(sizeof(PaddedPoint) == 16);
  expect_numbered(range_points(padded), 5, &padded[0].x);
  const auto lidar = numbered_points<LidarPoint>(5);
  expect_numbered(range_points(lidar), 5, &lidar[0].x);
  const auto doubles = numbered_points<DoublePoint>(5);
  expect_numbered(range_points(doubles), 5, &doubles[0].x);
  const auto interleaved = numbered_points<InterleavedPoint>(5);
  expect_numbered(range_points(interleaved), 5, &interleaved[0].x);
}

TEST(PointRanges, TakeSpansAndParts) {
  auto points = numbered_points<DoublePoint>(9);
  expect_numbered(range_points(std::span(points).first(4)), 4, &points[0].x);
  expect_numbered(range_points(std::span<const DoublePoint>(points)), 9, &points[0].x);
}

TEST(PointRanges, TakeSmallArrays) {
  const std::vector<std::array<float, 3>> arrays{{0, 1, 2}, {10, 11, 12}};
  expect_numbered(range_points(arrays), 2, arrays.data());
  const double rows[2][3] = {{0, 1, 2}, {10, 11, 12}};
  expect_numbered(range_points(rows), 2, rows);
  const std::vector<std::array<double, 4>> homogeneous{{0, 1, 2, 1}, {10, 11, 12, 1}};
  expect_numbered(range_points(homogeneous), 2, homogeneous.data());
}

TEST(PointRanges, GiveTheSameCorrespondencesAsPlainArrays) {
  const auto structs = numbered_points<LidarPoint>(70);
  std::vector<float> plain;
  for (const LidarPoint& p : structs) plain.insert(plain.end(), {p.x, p.y, p.z});
  const Correspondences a(range_points(structs), range_points(structs));
  const auto rows = PointSpan<float>::interleaved(plain.data(), 70);
  const Correspondences b(rows, rows);
  ASSERT_EQ(a.size(), 70u);
  EXPECT_EQ(a.source_centroid(), b.source_centroid());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < 70; ++i) EXPECT_EQ(a.view().target(axis)[i], b.view().target(axis)[i]);
  }
}

TEST(PointRanges, MayBeEmpty) {
  EXPECT_EQ(range_points(std::span<const LidarPoint>()).size, 0u);
  const std::vector<std::array<float, 3>> none;
  EXPECT_EQ(range_points(none).size, 0u);
}

TEST(PointRanges, RejectUnevenCoordinates) {
  const auto points = numbered_points<UnevenPoint>(2);
  try {
    (void)range_points(points);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "the x, y and z of a point are not evenly spaced: y is 1 elements after x, z 2 after y");
  }
}

template <typename Range>
concept Accepted = requires(Range&& range) {
  range_points(std::forward<Range>(range));
};

// What would dangle, or is not a point, does not compile.
static_assert(Accepted<std::vector<DoublePoint>&>);
static_assert(!Accepted<std::vector<DoublePoint>>);
static_assert(Accepted<std::span<DoublePoint>>);
static_assert(!Accepted<std::vector<std::vector<float>>&>);
static_assert(!Accepted<std::vector<std::span<float>>&>);
static_assert(!Accepted<std::vector<float*>&>);
static_assert(!Accepted<std::vector<std::array<int, 3>>&>);

}  // namespace
}  // namespace consimd::test
