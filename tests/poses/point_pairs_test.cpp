#include <consimd/poses/point_pairs.hpp>

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace consimd::test {
namespace {

struct Point {
  float x, y, z, intensity;
};

template <typename T>
void expect_numbered(const PointSpan<T>& span, std::size_t size) {
  ASSERT_EQ(span.size, size);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(span(i, c), static_cast<T>(10 * i + c));
  }
}

Eigen::Matrix3Xd columns(Eigen::Index size) {
  return Eigen::Matrix3Xd::NullaryExpr(3, size,
                                       [](Eigen::Index c, Eigen::Index i) { return static_cast<double>(10 * i + c); });
}

TEST(PointsOf, TakesWhatPointsAreIn) {
  expect_numbered(points_of(std::vector<Point>{{0, 1, 2, -1}, {10, 11, 12, -1}}), 2);
  expect_numbered(points_of(std::vector<std::array<double, 3>>{{0, 1, 2}, {10, 11, 12}}), 2);
  const Eigen::Matrix3Xd three_rows = columns(5);
  expect_numbered(points_of(three_rows), 5);
  expect_numbered(points_of(PointSpan<double>(column_points(three_rows))), 5);
  expect_numbered(points_of(three_rows.leftCols(4)), 4);
  const Eigen::Matrix<double, Eigen::Dynamic, 3> three_columns = three_rows.transpose();
  expect_numbered(points_of(three_columns), 5);
  const Eigen::MatrixXd either = three_rows;
  expect_numbered(points_of(either), 5);
  const Eigen::MatrixXd turned = three_columns;
  expect_numbered(points_of(turned), 5);
  const Eigen::Matrix3Xd square = columns(3);
  expect_numbered(points_of(square), 3);
}

TEST(PointsOf, NamesTheShapeItCannotTake) {
  const auto message_of = [](const Eigen::MatrixXd& matrix) -> std::string {
    try {
      static_cast<void>(points_of(matrix));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  for (const auto& [rows, cols] : {std::pair(3, 3), std::pair(4, 5), std::pair(2, 0)}) {
    EXPECT_EQ(message_of(Eigen::MatrixXd::Zero(rows, cols)),
              "points have " + std::to_string(rows) + " x " + std::to_string(cols) +
                  " coordinates, expected 3 x N or N x 3; column_points and row_points tell which");
  }
}

TEST(PointPairs, AreTheCorrespondences) {
  const Eigen::Matrix3Xd source = columns(70);
  const Eigen::Matrix<double, Eigen::Dynamic, 3> target = 2.0 * source.transpose();
  const Correspondences pairs = point_pairs(source, target);
  const Correspondences expected(column_points(source), row_points(target));
  ASSERT_EQ(pairs.size(), expected.size());
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      EXPECT_EQ(pairs.view().source(c)[k], expected.view().source(c)[k]);
      EXPECT_EQ(pairs.view().target(c)[k], expected.view().target(c)[k]);
    }
  }
  EXPECT_THROW(static_cast<void>(point_pairs(source, columns(69))), std::invalid_argument);
}

}  // namespace
}  // namespace consimd::test
