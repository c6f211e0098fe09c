#include <consimd/poses/eigen_points.hpp>

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/StdVector>
#include <string>
#include <vector>

#include <consimd/kernels/point_ranges.hpp>

namespace consimd::test {
namespace {

template <typename T>
using Columns = Eigen::Matrix<T, 3, Eigen::Dynamic>;
template <typename T>
using Rows = Eigen::Matrix<T, Eigen::Dynamic, 3>;
template <typename T>
using RowMajorRows = Eigen::Matrix<T, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// 3 x n: coordinate c of point i is 10 i + c.
template <typename T>
Columns<T> numbered(Eigen::Index n) {
  return Columns<T>::NullaryExpr(3, n, [](Eigen::Index c, Eigen::Index i) { return static_cast<T>(10 * i + c); });
}

template <typename T>
void expect_numbered(const PointSpan<T>& span, std::size_t n, const T* data) {
  EXPECT_EQ(span.data, data);
  ASSERT_EQ(span.size, n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(span(i, c), static_cast<T>(10 * i + c));
  }
}

template <typename T>
class EigenPoints : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(EigenPoints, Scalars);

TYPED_TEST(EigenPoints, TakeMatricesInPlace) {
  using T = TypeParam;
  const Columns<T> columns = numbered<T>(7);
  expect_numbered(column_points(columns), 7, columns.data());
  const Rows<T> rows = columns.transpose();
  expect_numbered(row_points(rows), 7, rows.data());
  const RowMajorRows<T> row_major = rows;
  expect_numbered(row_points(row_major), 7, row_major.data());
  const Eigen::Matrix<T, 3, Eigen::Dynamic, Eigen::RowMajor> planes = columns;
  expect_numbered(column_points(planes), 7, planes.data());
  const Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic> sized_later = columns;
  expect_numbered(column_points(sized_later), 7, sized_later.data());
  const Eigen::Matrix<T, 3, 4> fixed = columns.template leftCols<4>();
  expect_numbered(column_points(fixed), 4, fixed.data());
  const Eigen::Matrix<T, 3, 1> one = columns.col(0);
  expect_numbered(column_points(one), 1, one.data());
}

TYPED_TEST(EigenPoints, TakeBlocksAndMapsWithStrides) {
  using T = TypeParam;
  const Columns<T> columns = numbered<T>(9);
  expect_numbered(column_points(columns.leftCols(4)), 4, columns.data());
  expect_numbered(row_points(columns.transpose()), 9, columns.data());

  Eigen::Matrix<T, 4, Eigen::Dynamic> homogeneous(4, 9);
  homogeneous << columns, Eigen::Matrix<T, 1, Eigen::Dynamic>::Ones(9);
  expect_numbered(column_points(homogeneous.template topRows<3>()), 9, homogeneous.data());

  // Points at every eleventh number, their coordinates at every third.
  std::vector<T> memory(11 * 9, T{-1});
  for (Eigen::Index i = 0; i < 9; ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) memory[static_cast<std::size_t>(11 * i + 3 * c)] = columns(c, i);
  }
  using Strides = Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::Map<const Columns<T>, 0, Strides> map(memory.data(), 3, 9, Strides(11, 3));
  expect_numbered(column_points(map), 9, memory.data());
  const Eigen::Ref<const Columns<T>, 0, Strides> ref(map);
  expect_numbered(column_points(ref), 9, memory.data());
  expect_numbered(row_points(map.transpose()), 9, memory.data());
}

TEST(EigenPointRanges, TakeVectorsOfEigensVectors) {
  const std::vector<Eigen::Vector3d> vectors{{0, 1, 2}, {10, 11, 12}};
  expect_numbered(range_points(vectors), 2, vectors[0].data());
  const std::vector<Eigen::Vector4f, Eigen::aligned_allocator<Eigen::Vector4f>> padded{{0, 1, 2, 1}, {10, 11, 12, 1}};
  expect_numbered(range_points(padded), 2, padded[0].data());
}

template <typename Call>
std::string message_of(const Call& call) {
  try {
    (void)call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(EigenPointSizes, MustHaveThreeCoordinates) {
  const Eigen::MatrixXd four = Eigen::MatrixXd::Zero(4, 100);
  EXPECT_EQ(message_of([&] { return column_points(four); }), "points have 4 x 100 coordinates, expected 3 x N");
  EXPECT_EQ(message_of([&] { return row_points(four); }), "points have 4 x 100 coordinates, expected N x 3");
  const Eigen::Matrix3Xd none(3, 0);
  EXPECT_EQ(column_points(none).size, 0u);
}

template <typename M>
concept Accepted = requires(M&& points) {
  column_points(std::forward<M>(points));
};

// A matrix that is gone at the end of the line does not compile.
static_assert(Accepted<Eigen::Matrix3Xd&>);
static_assert(Accepted<const Eigen::Matrix3Xd&>);
static_assert(!Accepted<Eigen::Matrix3Xd>);
static_assert(Accepted<Eigen::Map<Eigen::Matrix3Xd>>);

}  // namespace
}  // namespace consimd::test
