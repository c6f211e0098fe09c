#include <consimd/solvers/one_point_ransac.hpp>

#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include "problems.hpp"

namespace consimd::test {
namespace {

std::size_t consistent_with(const Problem& problem, std::uint32_t k, double bound) {
  const std::vector<std::uint32_t> rows = all_rows(problem);
  return static_cast<std::size_t>(
      std::ranges::count_if(rows, [&](std::uint32_t j) { return length_difference(problem, j, k) < bound; }));
}

/// Whether `members` are the rows consistent with `k`; those within `border` of the bound may be either.
bool is_consensus_set_of(const Problem& problem, std::uint32_t k, std::span<const std::uint32_t> members, double bound,
                         double border) {
  return std::ranges::all_of(all_rows(problem), [&](std::uint32_t j) {
    const double difference = length_difference(problem, j, k);
    return std::abs(difference - bound) <= border || std::ranges::binary_search(members, j) == (difference < bound);
  });
}

/// Share of consistent pairs among `members`.
double mutual_consistency(const Problem& problem, std::span<const std::uint32_t> members, double bound) {
  std::size_t consistent = 0;
  for (const std::uint32_t j : members) {
    for (const std::uint32_t k : members) {
      if (length_difference(problem, j, k) < bound) ++consistent;
    }
  }
  return static_cast<double>(consistent) / static_cast<double>(members.size() * members.size());
}

class OnePointRansac : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, OnePointRansac, ::testing::Range(std::uint64_t{1}, std::uint64_t{6}));

TEST_P(OnePointRansac, UnprunedIsTheConsensusSetOfACorrespondence) {
  const Problem problem =
      synth::noise_study_problem({.correspondences = 500, .outlier_ratio = 0.9, .seed = GetParam()});
  const Correspondences correspondences = problem.correspondences();
  const double bound = 6.0;
  const ConsensusSet set =
      one_point_ransac(correspondences, {.consistency_bound = bound, .prune = false, .seed = GetParam()});
  EXPECT_EQ(set.score, set.members.size());
  EXPECT_TRUE(std::ranges::is_sorted(set.members, std::ranges::less_equal{}));
  EXPECT_TRUE(std::ranges::any_of(set.members, [&](std::uint32_t k) {
    return is_consensus_set_of(problem, k, set.members, bound, rounding(correspondences));
  }));
}

TEST_P(OnePointRansac, UnprunedIsTheLargestSetOnceEveryCorrespondenceWasDrawn) {
  // No true motion and a small bound: sets stay small, so the stopping rule asks for about ten draws of each row.
  const Problem problem = synth::noise_study_problem({.correspondences = 60, .outlier_ratio = 1.0, .seed = GetParam()});
  std::size_t largest = 0;
  for (std::uint32_t k = 0; k < problem.size(); ++k) largest = std::max(largest, consistent_with(problem, k, 1.0));
  const ConsensusSet set =
      one_point_ransac(problem.correspondences(),
                       {.consistency_bound = 1.0, .confidence = 1.0 - 1e-15, .prune = false, .seed = GetParam()});
  EXPECT_EQ(set.score, largest);
}

TEST_P(OnePointRansac, PruningLeavesMembersThatAgreeWithOneAnother) {
  const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.95, .sigma = 1.0, .seed = GetParam()});
  const Correspondences correspondences = problem.correspondences();
  const OnePointOptions options{.consistency_bound = 6.0, .seed = GetParam()};
  OnePointOptions unpruned = options;
  unpruned.prune = false;
  const ConsensusSet set = one_point_ransac(correspondences, options);
  EXPECT_EQ(set.score, set.members.size());
  EXPECT_TRUE(std::ranges::is_sorted(set.members, std::ranges::less_equal{}));
  EXPECT_GT(mutual_consistency(problem, set.members, 6.0), 0.9);
  EXPECT_LT(mutual_consistency(problem, one_point_ransac(correspondences, unpruned).members, 6.0), 0.6);
  const synth::InlierQuality quality = synth::inlier_quality(problem, set.members);
  EXPECT_GT(quality.precision, 0.9);
  EXPECT_GT(quality.recall, 0.9);
}

class OnePointStop : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(InlierShares, OnePointStop, ::testing::Values(1.0, 0.9, 0.5, 0.1, 0.02));

TEST_P(OnePointStop, FollowsTheClosedForm) {
  const Problem problem =
      synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 1.0 - GetParam(), .sigma = 0.0});
  const Correspondences correspondences = problem.correspondences();
  std::uint64_t fewest = std::numeric_limits<std::uint64_t>::max();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ConsensusSet set = one_point_ransac(
        correspondences, {.consistency_bound = 0.01, .confidence = 0.99, .prune = false, .seed = seed});
    // The set of an inlier: all inliers, and hardly anything else.
    ASSERT_NEAR(static_cast<double>(set.score), 1000.0 * GetParam(), 3.0);
    const double share = static_cast<double>(set.score) / 1000.0;
    const double needed = share == 1.0 ? 1.0 : std::log(1.0 - 0.99) / std::log(1.0 - share);
    EXPECT_GE(static_cast<double>(set.iterations), needed) << "seed " << seed;
    fewest = std::min(fewest, set.iterations);
    // It goes on only where the first inlier came late: twice as late has a chance of 1e-4.
    EXPECT_LE(static_cast<double>(set.iterations), 2.0 * needed + 2.0) << "seed " << seed;
  }
  const double share = GetParam();
  const double needed = share == 1.0 ? 1.0 : std::log(1.0 - 0.99) / std::log(1.0 - share);
  EXPECT_LE(static_cast<double>(fewest), std::ceil(needed) + 1.0);
}

TEST(OnePointRansac, NeverExceedsMaxIterations) {
  const Problem problem = synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 1.0});
  const Correspondences correspondences = problem.correspondences();
  for (const std::uint32_t limit : {0u, 1u, 31u, 32u, 33u, 500u}) {
    const ConsensusSet set = one_point_ransac(correspondences, {.consistency_bound = 0.01, .max_iterations = limit});
    EXPECT_EQ(set.iterations, limit);
  }
}

TEST(OnePointRansac, SmallInputs) {
  EXPECT_TRUE(one_point_ransac(Correspondences(), {.consistency_bound = 1.0}).members.empty());
  const std::vector<Eigen::Vector3d> points{{0.0, 0.0, 0.0}, {10.0, 0.0, 0.0}};
  Problem problem = perfect_problem(points, motion(1.0, {1.0, 2.0, 3.0}, {5.0, 6.0, 7.0}));
  for (const bool prune : {false, true}) {
    const OnePointOptions options{.consistency_bound = 1.0, .prune = prune};
    const std::vector<std::uint32_t> rows{0, 1};
    const Problem one = chosen_rows(problem, std::span(rows).first(1));
    EXPECT_EQ(one_point_ransac(one.correspondences(), options).members, std::vector<std::uint32_t>{0});
    EXPECT_EQ(one_point_ransac(problem.correspondences(), options).members, rows);
    Problem stretched = problem;
    stretched.source[3] = 12.0;
    EXPECT_EQ(one_point_ransac(stretched.correspondences(), options).members.size(), 1u);
  }
}

TEST(OnePointRansac, RejectsBadOptions) {
  const Correspondences correspondences = synth::noise_study_problem({.correspondences = 10}).correspondences();
  for (const double bound : kBadLengths) {
    const OnePointOptions options{.consistency_bound = bound};
    expect_rejected([&] { static_cast<void>(one_point_ransac(correspondences, options)); }, "consistency_bound", bound);
  }
  for (const double confidence : kBadConfidences) {
    const OnePointOptions options{.consistency_bound = 1.0, .confidence = confidence};
    expect_rejected([&] { static_cast<void>(one_point_ransac(correspondences, options)); }, "confidence", confidence);
  }
}

}  // namespace
}  // namespace consimd::test
