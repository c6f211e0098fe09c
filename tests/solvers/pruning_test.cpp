// Pruning of consensus sets: what stays is a smaller set, which holds the cliques that it must hold.
#include "search/pruning.hpp"

#include <consimd/synth/noise_study.hpp>

#include <algorithm>
#include <functional>
#include <ostream>
#include <tuple>

#include "problems.hpp"

namespace consimd::detail {

void PrintTo(Merit merit, std::ostream* out) { *out << (merit == Merit::degree ? "degree" : "excess"); }

}  // namespace consimd::detail

namespace consimd::test {
namespace {

using detail::Merit;

std::vector<std::uint32_t> neighbours(const ConsistencyMatrix& matrix, std::uint32_t row) {
  std::vector<std::uint32_t> rows;
  for (std::uint32_t other = 0; other < matrix.size(); ++other) {
    if ((matrix.row(row)[other / 64] >> (other % 64) & 1) != 0) rows.push_back(other);
  }
  return rows;
}

class Pruning : public ::testing::TestWithParam<std::tuple<Merit, std::uint32_t>> {
 protected:
  [[nodiscard]] std::vector<std::uint32_t> pruned(const ConsistencyMatrix& matrix, std::vector<std::uint32_t> set) {
    const auto [merit, give_up_below] = GetParam();
    detail::prune(matrix, set, give_up_below, merit, {}, scratch_);
    return set;
  }

 private:
  detail::PruneScratch scratch_;
};

// A round that wants to keep `give_up_below` members of a set that has fewer keeps those that there are.
TEST_P(Pruning, LeavesAnAscendingPartOfTheSet) {
  for (std::uint64_t trial = 0; trial < 4; ++trial) {
    const Problem problem =
        synth::noise_study_problem({.correspondences = 700, .outlier_ratio = 0.95, .sigma = 0.5, .trial = trial});
    ConsistencyMatrix matrix;
    matrix.compute(problem.correspondences(), 1.5);
    for (std::uint32_t row = 0; row < matrix.size(); row += 7) {
      const std::vector<std::uint32_t> set = neighbours(matrix, row);
      const std::vector<std::uint32_t> kept = pruned(matrix, set);
      EXPECT_LE(kept.size(), set.size());
      EXPECT_TRUE(std::ranges::includes(set, kept));
      EXPECT_EQ(std::ranges::adjacent_find(kept, std::ranges::greater_equal()), kept.end());
    }
  }
}

// Twenty exact rows among 400: the set of one of them holds them all, and some that chance brings.
TEST_P(Pruning, KeepsACliqueThatStandsOut) {
  for (std::uint64_t trial = 0; trial < 10; ++trial) {
    const Problem problem =
        synth::noise_study_problem({.correspondences = 400, .outlier_ratio = 0.95, .sigma = 0.01, .trial = trial});
    ConsistencyMatrix matrix;
    matrix.compute(problem.correspondences(), 4.0);
    std::vector<std::uint32_t> inliers;
    for (std::uint32_t row = 0; row < problem.size(); ++row) {
      if (problem.is_inlier[row]) inliers.push_back(row);
    }
    ASSERT_EQ(inliers.size(), 20U);
    const std::vector<std::uint32_t> set = neighbours(matrix, inliers.front());
    ASSERT_GT(set.size(), inliers.size());
    const std::vector<std::uint32_t> kept = pruned(matrix, set);
    // No clique of more members than that many consistent pairs allow.
    if (std::get<1>(GetParam()) > set.size()) {
      EXPECT_TRUE(kept.empty());
    } else {
      EXPECT_TRUE(std::ranges::includes(kept, inliers));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(MeritsAndLimits, Pruning,
                         ::testing::Combine(::testing::Values(Merit::degree, Merit::excess),
                                            ::testing::Values(0U, 10U, 20U, 150U)));

}  // namespace
}  // namespace consimd::test
