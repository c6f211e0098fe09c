// TCF as printed in the paper.
#include <consimd/solvers/one_point_ransac.hpp>
#include <consimd/solvers/sa_cauchy_irls.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/tcf_published.hpp>
#include <consimd/solvers/three_point_ransac.hpp>
#include <consimd/solvers/two_point_ransac.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <optional>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

/// A problem of the noise study whose clouds are hardly rotated against each other, as Eq. (alpha-angle) needs.
Problem hardly_rotated(double outlier_ratio, std::uint64_t trial) {
  Problem problem =
      synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = outlier_ratio, .trial = trial});
  const RigidTransform back = motion(0.02, {3.0, 2.0, 1.0}, {0.0, 10.0, 20.0}) * problem.T_target_source.inverse();
  return with_moved_target(std::move(problem), back);
}

class TcfPublished : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(OutlierRatios, TcfPublished, ::testing::Values(0.0, 0.5, 0.9));

TEST_P(TcfPublished, FindsPosesOfHardlyRotatedClouds) {
  for (std::uint64_t trial = 0; trial < 5; ++trial) {
    const Problem problem = hardly_rotated(GetParam(), trial);
    const Registration result = register_tcf_published(problem.correspondences(), {.noise_bound = 3.0, .seed = trial});
    expect_sound(result, problem, 3.0);
    EXPECT_EQ(result.status, Status::success) << "trial " << trial;
    EXPECT_LT(synth::rmse_true_inliers(problem, result.T_target_source), 3.0) << "trial " << trial;
  }
}

TEST(TcfPublishedVerdict, NoPoseIsNoSuccess) {
  for (std::uint64_t trial = 0; trial < 10; ++trial) {
    const Problem problem = synth::hard_problem({.correspondences = 1000,
                                                 .outlier_ratio = 1.0,
                                                 .sigma = 5.0,
                                                 .seed = 3,
                                                 .trial = static_cast<std::uint32_t>(trial)});
    const Registration result = register_tcf_published(problem.correspondences(), {.noise_bound = 15.0, .seed = trial});
    EXPECT_FALSE(result.has_pose()) << "trial " << trial;
    expect_sound(result, problem, 15.0);
  }
}

// Its angle test keeps a part of the right rows of rotated clouds, and the pose of these may leave most others.
TEST(TcfPublishedVerdict, APoseThatLeavesMostOfTheConsensusIsNoSuccess) {
  std::size_t ambiguous = 0;
  for (std::uint64_t trial = 0; trial < 40; ++trial) {
    const Problem problem = synth::noise_study_problem(
        {.correspondences = 1000, .outlier_ratio = trial % 2 == 0 ? 0.1 : 0.5, .trial = trial});
    const Registration result = register_tcf_published(problem.correspondences(), {.noise_bound = 3.0, .seed = trial});
    if (!result.has_pose()) continue;
    const bool is_right = synth::rmse_true_inliers(problem, result.T_target_source) < 3.0;
    if (result.status == Status::success) {
      EXPECT_TRUE(is_right) << trial;
    } else {
      ASSERT_EQ(result.status, Status::ambiguous) << trial;
      ASSERT_TRUE(result.runner_up) << trial;
      EXPECT_GT(4 * result.runner_up->support, 5 * result.inliers.size()) << trial;
      EXPECT_LT(synth::rmse_true_inliers(problem, result.runner_up->T_target_source), 3.0) << trial;
      ++ambiguous;
    }
  }
  EXPECT_GE(ambiguous, 2U);  // there are four
}

TEST(TcfPublishedVerdict, EndsBeforeItsStagesWhereNoPoseCanBe) {
  const std::vector<double> same(3 * 5000, 1.0);
  // Single precision holds the points of one line exactly and rounds those of the other.
  std::vector<double> exact;
  std::vector<double> rounded;
  for (int k = 0; k < 5000; ++k) {
    exact.insert(exact.end(), {1.0 * k, 2.0 * k, -3.0 * k});
    rounded.insert(rounded.end(), {1e5 + k / 3.0, 7.0 - k / 7.0, k / 11.0});
  }
  for (const std::vector<double>& points : {same, exact, rounded}) {
    const auto span = PointSpan<double>::interleaved(points.data(), points.size() / 3);
    const Registration result = register_tcf_published({span, span}, {.noise_bound = 0.3});
    EXPECT_EQ(result.status, Status::degenerate_geometry);
    EXPECT_TRUE(result.stages.empty());
  }
}

TEST_P(TcfPublished, FindsThemWithoutABound) {
  for (std::uint64_t trial = 0; trial < 2; ++trial) {
    const Problem problem = hardly_rotated(GetParam(), trial);
    const Registration result =
        register_by_name("tcf-published", problem.correspondences(), {.noise_bound = std::nullopt, .seed = trial});
    expect_sound(result, problem, result.noise_bound);
    EXPECT_NEAR(result.noise_bound, 3.0, 0.6) << "trial " << trial;
    EXPECT_EQ(result.status, Status::success) << "trial " << trial;
    EXPECT_LT(synth::rmse_true_inliers(problem, result.T_target_source), 3.0) << "trial " << trial;
  }
}

TEST_P(TcfPublished, IsItsStagesInARow) {
  const double tau = 3.0;
  const Problem problem = hardly_rotated(GetParam(), 7);
  const Correspondences correspondences = problem.correspondences();
  const Registration result = register_tcf_published(correspondences, {.noise_bound = tau, .seed = 3});

  const ConsensusSet one =
      one_point_ransac(correspondences, {.consistency_bound = 2.0 * tau, .prune = false, .seed = 3});
  const ConsensusSet two = two_point_ransac(correspondences, one.members,
                                            {.consistency_bound = 2.0 * tau,
                                             .angle_bound = tau,
                                             .angle_test = AngleTest::as_printed,
                                             .prune = false,
                                             .seed = 3});
  const ThreePointResult three = three_point_ransac(correspondences, two.members, {.noise_bound = tau, .seed = 3});
  const IrlsResult irls =
      sa_cauchy_irls(correspondences, three.consensus.members, {.rule = SaCauchyIrlsOptions::Rule::as_printed});

  EXPECT_EQ(result.T_target_source.matrix(), to_caller_frame(irls.fit.pose, correspondences).matrix());
  ASSERT_EQ(result.stages.size(), 5u);
  const auto expect_stage = [&](std::size_t s, const std::string& name, std::size_t input, std::size_t output,
                                std::uint64_t iterations) {
    EXPECT_EQ(result.stages[s].name, name);
    EXPECT_EQ(result.stages[s].input, input) << name;
    EXPECT_EQ(result.stages[s].output, output) << name;
    EXPECT_EQ(result.stages[s].iterations, iterations) << name;
  };
  expect_stage(0, "one_point", problem.size(), one.members.size(), one.iterations);
  expect_stage(1, "two_point", one.members.size(), two.members.size(), two.iterations);
  expect_stage(2, "three_point", two.members.size(), three.consensus.members.size(), three.consensus.iterations);
  expect_stage(3, "irls", three.consensus.members.size(), irls.members.size(), irls.rounds);
  expect_stage(4, "significance", problem.size(), result.inliers.size(), 0);
}

TEST(TcfPublishedOptions, AreThePapers) {
  const TcfPublishedOptions options;
  EXPECT_EQ(options.seed, 1u);
  EXPECT_EQ(options.confidence, 0.99);
  EXPECT_EQ(options.max_iterations, 10'000u);
}

TEST(TcfPublishedOptions, BadOnesAreRejected) {
  const Correspondences correspondences = synth::noise_study_problem({.correspondences = 50}).correspondences();
  const auto run_with = [&](double noise_bound, double confidence) {
    return [&correspondences, noise_bound, confidence] {
      static_cast<void>(
          register_tcf_published(correspondences, {.noise_bound = noise_bound, .confidence = confidence}));
    };
  };
  for (const double bound : kBadLengths) expect_rejected(run_with(bound, 0.99), "noise_bound", bound);
  for (const double confidence : kBadConfidences) expect_rejected(run_with(1.0, confidence), "confidence", confidence);
}

TEST(TcfPublishedOptions, BoundTheIterationsOfEachStage) {
  const Problem problem = hardly_rotated(0.9, 0);
  for (const std::uint32_t most : {1U, 7U}) {
    const Registration result =
        register_tcf_published(problem.correspondences(), {.noise_bound = 3.0, .max_iterations = most});
    ASSERT_GE(result.stages.size(), 3u);
    for (std::size_t s = 0; s < 3; ++s) EXPECT_LE(result.stages[s].iterations, most) << result.stages[s].name;
  }
}

TEST(TcfPublishedOptions, FewCorrespondencesHaveTheirStatus) {
  const Problem problem = synth::noise_study_problem({.correspondences = 2, .outlier_ratio = 0.0});
  EXPECT_EQ(register_tcf_published(problem.correspondences(), {.noise_bound = 3.0}).status,
            Status::too_few_correspondences);
}

}  // namespace
}  // namespace consimd::test
