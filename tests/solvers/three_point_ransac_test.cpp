#include <consimd/solvers/three_point_ransac.hpp>

#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include "problems.hpp"

namespace consimd::test {
namespace {

class ThreePointRansac : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Sigmas, ThreePointRansac, ::testing::Values(0.0, 0.1, 1.0, 5.0));

TEST_P(ThreePointRansac, RecoversTheTruePoseAndItsConsensus) {
  const double bound = std::max(3.0 * GetParam(), 0.01);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Problem problem =
        synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.5, .sigma = GetParam(), .seed = seed});
    const Correspondences correspondences = problem.correspondences();
    // Every other row, in an order of its own: rows that are no candidates must not appear.
    std::vector<std::uint32_t> candidates = random_order(200, static_cast<std::uint32_t>(seed));
    candidates.resize(100);
    const ThreePointResult result =
        three_point_ransac(correspondences, candidates, {.noise_bound = bound, .seed = seed});

    const RigidTransform T = to_caller_frame(result.pose, correspondences);
    expect_proper_rotation(T);
    EXPECT_LT(synth::rmse_true_inliers(problem, T), bound) << "seed " << seed;
    std::ranges::sort(candidates);
    std::vector<std::uint32_t> positions;
    for (const std::uint32_t k : result.consensus.members) {
      const auto found = std::ranges::lower_bound(candidates, k);
      ASSERT_TRUE(found != candidates.end() && *found == k) << k;
      positions.push_back(static_cast<std::uint32_t>(found - candidates.begin()));
    }
    expect_rows_within(positions, chosen_rows(problem, candidates), T, bound);
    EXPECT_EQ(result.consensus.score, result.consensus.members.size());
  }
}

class ThreePointStop : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(InlierShares, ThreePointStop, ::testing::Values(1.0, 0.8, 0.5, 0.2));

TEST_P(ThreePointStop, FollowsTheClosedForm) {
  const Problem problem =
      synth::noise_study_problem({.correspondences = 500, .outlier_ratio = 1.0 - GetParam(), .sigma = 0.0});
  const Correspondences correspondences = problem.correspondences();
  std::uint64_t fewest = std::numeric_limits<std::uint64_t>::max();
  double needed = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ConsensusSet set =
        three_point_ransac(correspondences, all_rows(problem), {.noise_bound = 0.5, .confidence = 0.99, .seed = seed})
            .consensus;
    ASSERT_NEAR(static_cast<double>(set.score), 500.0 * GetParam(), 2.0);
    const double share = static_cast<double>(set.score) / 500.0;
    needed = share == 1.0 ? 1.0 : std::log(1.0 - 0.99) / std::log(1.0 - share * share * share);
    EXPECT_GE(static_cast<double>(set.iterations), needed) << "seed " << seed;
    EXPECT_LE(static_cast<double>(set.iterations), 2.0 * needed + 2.0) << "seed " << seed;
    fewest = std::min(fewest, set.iterations);
  }
  EXPECT_LE(static_cast<double>(fewest), std::ceil(needed) + 1.0);
}

TEST(ThreePointRansac, NeverExceedsMaxIterations) {
  const Problem problem = synth::noise_study_problem({.correspondences = 100, .outlier_ratio = 1.0});
  const Correspondences correspondences = problem.correspondences();
  for (const std::uint32_t limit : {0u, 1u, 32u, 33u, 100u}) {
    const ThreePointOptions options{.noise_bound = 0.01, .max_iterations = limit};
    EXPECT_EQ(three_point_ransac(correspondences, all_rows(problem), options).consensus.iterations, limit);
  }
}

TEST(ThreePointRansac, FewerThanThreeCandidatesGiveNothing) {
  const Problem problem = synth::noise_study_problem({.correspondences = 10, .outlier_ratio = 0.0, .sigma = 0.0});
  const Correspondences correspondences = problem.correspondences();
  const std::vector<std::uint32_t> rows{7, 2, 4};
  for (std::size_t n = 0; n < 3; ++n) {
    const ThreePointResult result = three_point_ransac(correspondences, std::span(rows).first(n), {.noise_bound = 0.1});
    EXPECT_TRUE(result.consensus.members.empty());
    EXPECT_EQ(result.consensus.score, 0u);
    EXPECT_EQ(result.pose.matrix(), Eigen::Matrix4d::Identity());
  }
  const ThreePointResult result = three_point_ransac(correspondences, rows, {.noise_bound = 0.1});
  EXPECT_EQ(result.consensus.members, (std::vector<std::uint32_t>{2, 4, 7}));
}

TEST(ThreePointRansac, CoincidentCandidatesHaveNoPose) {
  const std::vector<Eigen::Vector3d> points(20, Eigen::Vector3d(1.0, 2.0, 3.0));
  const Problem problem = perfect_problem(points, motion(1.0, {0.0, 0.0, 1.0}, {5.0, 6.0, 7.0}));
  const ThreePointResult result =
      three_point_ransac(problem.correspondences(), all_rows(problem), {.noise_bound = 0.1, .max_iterations = 100});
  EXPECT_TRUE(result.consensus.members.empty());
  EXPECT_TRUE(result.pose.matrix().allFinite());
}

TEST(ThreePointRansac, RejectsBadOptions) {
  const Problem problem = synth::noise_study_problem({.correspondences = 10});
  const Correspondences correspondences = problem.correspondences();
  const auto run = [&](const ThreePointOptions& options) {
    return [&, options] { static_cast<void>(three_point_ransac(correspondences, all_rows(problem), options)); };
  };
  for (const double bound : kBadLengths) expect_rejected(run({.noise_bound = bound}), "noise_bound", bound);
  for (const double confidence : kBadConfidences) {
    expect_rejected(run({.noise_bound = 1.0, .confidence = confidence}), "confidence", confidence);
  }
}

}  // namespace
}  // namespace consimd::test
