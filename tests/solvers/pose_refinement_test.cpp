#include <consimd/solvers/pose_refinement.hpp>

#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <ostream>

#include "problems.hpp"

namespace consimd::test {
namespace {

/// The true pose, off by about a noise bound at the rim of the scene.
WorkingPose start_near_truth(const Problem& problem, const Correspondences& correspondences) {
  const double bound = synth::noise_study_bound(problem.sigma);
  const RigidTransform offset = motion(bound / 200.0, {1.0, -2.0, 3.0}, Eigen::Vector3d::Constant(bound / 4.0));
  return to_working_pose(to_working_frame(problem.T_target_source * offset, correspondences));
}

struct Cell {
  double outlier_ratio;
  double sigma;
  double error_ratio;  ///< largest accepted mean error over the oracle's
};

void PrintTo(const Cell& cell, std::ostream* out) { *out << cell.outlier_ratio << " outliers, sigma " << cell.sigma; }

class RefinePose : public ::testing::TestWithParam<Cell> {};
INSTANTIATE_TEST_SUITE_P(Cells, RefinePose,
                         ::testing::Values(Cell{0.0, 1.0, 1.02}, Cell{0.1, 1.0, 1.02}, Cell{0.5, 5.0, 1.05},
                                           Cell{0.9, 0.1, 1.02}, Cell{0.9, 1.0, 1.03}, Cell{0.95, 2.5, 1.05},
                                           Cell{0.98, 1.0, 1.05}, Cell{0.98, 5.0, 1.15}));

TEST_P(RefinePose, ReachesTheOracleAndEstimatesTheNoise) {
  constexpr int kTrials = 30;
  double rotation = 0.0, oracle_rotation = 0.0, translation = 0.0, oracle_translation = 0.0;
  double sigma = 0.0, inliers = 0.0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const Problem problem = synth::noise_study_problem(
        {.outlier_ratio = GetParam().outlier_ratio, .sigma = GetParam().sigma, .trial = trial});
    const Correspondences correspondences = problem.correspondences();
    const RefinedPose refined = refine_pose(correspondences, start_near_truth(problem, correspondences),
                                            {.noise_bound = synth::noise_study_bound(problem.sigma)});
    ASSERT_TRUE(refined.fit.determined());
    const RigidTransform T = to_caller_frame(refined.fit.pose, correspondences);
    const RigidTransform oracle = synth::oracle(problem);
    expect_proper_rotation(T);
    rotation += synth::rotation_error_deg(T, problem.T_target_source);
    translation += synth::translation_error(T, problem.T_target_source);
    oracle_rotation += synth::rotation_error_deg(oracle, problem.T_target_source);
    oracle_translation += synth::translation_error(oracle, problem.T_target_source);
    sigma += refined.sigma / kTrials;
    inliers += refined.inliers / static_cast<double>(true_inliers(problem).size()) / kTrials;
    EXPECT_GE(refined.rounds, 1u);
    EXPECT_LE(refined.rounds, 30u);
    EXPECT_GT(refined.outlier_density, 0.0);
  }
  EXPECT_LT(rotation, GetParam().error_ratio * oracle_rotation);
  EXPECT_LT(translation, GetParam().error_ratio * oracle_translation);
  EXPECT_NEAR(sigma, GetParam().sigma, 0.1 * GetParam().sigma);
  EXPECT_NEAR(inliers, 1.0, 0.1);
}

TEST(RefinePoseInput, PerfectDataGiveTheTruth) {
  const Problem problem = synth::noise_study_problem({.correspondences = 100, .outlier_ratio = 0.5, .sigma = 0.0});
  const Correspondences correspondences = problem.correspondences();
  const WorkingPose start = to_working_pose(to_working_frame(problem.T_target_source, correspondences));
  const RefinedPose refined = refine_pose(correspondences, start, {.noise_bound = 0.1});
  const RigidTransform T = to_caller_frame(refined.fit.pose, correspondences);
  EXPECT_LT(synth::rotation_error_deg(T, problem.T_target_source), 1e-4);
  EXPECT_LT(synth::translation_error(T, problem.T_target_source), 1e-4);
  EXPECT_GT(refined.sigma, 0.0);
}

TEST(RefinePoseInput, APoseThatNothingSupportsIsNotDetermined) {
  const Problem problem = synth::noise_study_problem({.correspondences = 100, .outlier_ratio = 0.0, .sigma = 0.0});
  const Correspondences correspondences = problem.correspondences();
  const RigidTransform far = motion(3.0, {1.0, 0.0, 0.0}, {1e4, 0.0, 0.0}) * problem.T_target_source;
  const RefinedPose refined =
      refine_pose(correspondences, to_working_pose(to_working_frame(far, correspondences)), {.noise_bound = 0.1});
  EXPECT_FALSE(refined.fit.determined());
  EXPECT_TRUE(refined.fit.pose.matrix().allFinite());
}

TEST(RefinePoseInput, RejectsBadBounds) {
  const Problem problem = synth::noise_study_problem({.correspondences = 10});
  const Correspondences correspondences = problem.correspondences();
  for (const double bound : kBadLengths) {
    expect_rejected(
        [&] {
          static_cast<void>(
              refine_pose(correspondences, start_near_truth(problem, correspondences), {.noise_bound = bound}));
        },
        "noise_bound", bound);
  }
}

}  // namespace
}  // namespace consimd::test
