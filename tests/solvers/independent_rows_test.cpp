// Independent rows: what is matched cluster to cluster is told by a few rows, what is far apart stays.
#include "support/independent_rows.hpp"

#include <consimd/synth/hard_problems.hpp>

#include <algorithm>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

class IndependentRows : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Radii, IndependentRows, ::testing::Values(3.0, 9.0, 40.0));

void expect_those_not_close_to_one_before(const Problem& problem, double radius) {
  const Correspondences correspondences = problem.correspondences();
  const std::vector<std::uint32_t> rows = detail::independent_rows(correspondences.view(), radius);
  ASSERT_TRUE(std::ranges::is_sorted(rows));
  EXPECT_LT(rows.size(), problem.size());
  const double slack = 1e-4 * radius;  // the working frame is in single precision
  const auto close = [&](std::size_t i, std::size_t j, double within) {
    return (source_point(problem, i) - source_point(problem, j)).norm() < within &&
           (target_point(problem, i) - target_point(problem, j)).norm() < within;
  };
  for (std::uint32_t row = 0; row < problem.size(); ++row) {
    const bool kept = std::ranges::binary_search(rows, row);
    const bool repeats = std::ranges::any_of(
        rows, [&](std::uint32_t other) { return other < row && close(row, other, radius + (kept ? -slack : slack)); });
    EXPECT_NE(kept, repeats) << row;
  }
}

TEST_P(IndependentRows, AreThoseNotCloseToOneBefore) {
  expect_those_not_close_to_one_before(
      synth::hard_problem({.correspondences = 600, .outlier_ratio = 0.9, .outliers = synth::OutlierModel::clustered}),
      GetParam());
}

// More rows than one by one are looked at share a source.
TEST_P(IndependentRows, AreTheSameWhereAPointIsMatchedWithAll) {
  for (const bool of_target : {false, true}) {
    Problem problem = synth::hard_problem({.correspondences = 1500, .outlier_ratio = 0.9});
    std::vector<double>& points = of_target ? problem.target : problem.source;
    for (std::size_t k = 3; k < 3 * 1200; ++k) points[k] = points[k % 3];
    expect_those_not_close_to_one_before(problem, GetParam());
  }
}

TEST(IndependentRows, OneStandsForCoincidentOnes) {
  const Problem problem = synth::hard_problem({.correspondences = 50, .outlier_ratio = 0.0, .duplicates = 100});
  EXPECT_LE(detail::independent_rows(problem.correspondences().view(), 1e-9).size(), 50U);
}

}  // namespace
}  // namespace consimd::test
