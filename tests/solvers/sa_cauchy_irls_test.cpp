#include <consimd/solvers/sa_cauchy_irls.hpp>

#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <ostream>

#include "problems.hpp"

namespace consimd {

void PrintTo(SaCauchyIrlsOptions::Rule rule, std::ostream* out) {
  *out << (rule == SaCauchyIrlsOptions::Rule::as_printed ? "as_printed" : "scale_free");
}

namespace test {
namespace {

using Rule = SaCauchyIrlsOptions::Rule;

IrlsResult run(const Problem& problem, Rule rule, double final_scale) {
  return sa_cauchy_irls(problem.correspondences(), all_rows(problem), {.rule = rule, .final_scale = final_scale});
}

RigidTransform caller_pose(const Problem& problem, const IrlsResult& result) {
  return to_caller_frame(result.fit.pose, problem.correspondences());
}

/// Least squares over all rows, as if all were inliers.
RigidTransform plain_fit(Problem problem) {
  problem.is_inlier.assign(problem.size(), 1);
  return synth::oracle(problem);
}

class SaCauchyIrls : public ::testing::TestWithParam<Rule> {};
INSTANTIATE_TEST_SUITE_P(Rules, SaCauchyIrls, ::testing::Values(Rule::scale_free, Rule::as_printed));

TEST_P(SaCauchyIrls, PerfectDataGiveTheTruth) {
  const Problem problem = synth::noise_study_problem({.correspondences = 50, .outlier_ratio = 0.0, .sigma = 0.0});
  const IrlsResult result = run(problem, GetParam(), 0.1);
  const RigidTransform T = caller_pose(problem, result);
  EXPECT_TRUE(result.fit.determined());
  expect_proper_rotation(T);
  EXPECT_LT(synth::rotation_error_deg(T, problem.T_target_source), 1e-4);
  EXPECT_LT(synth::translation_error(T, problem.T_target_source), 1e-4);
}

TEST_P(SaCauchyIrls, IsRobustToAFewOutliers) {
  double error = 0.0;
  double oracle_error = 0.0;
  double plain_error = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Problem problem = synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.1, .seed = seed});
    const IrlsResult result = run(problem, GetParam(), 3.0);
    EXPECT_LE(result.rounds, 100u);
    error += synth::rotation_error_deg(caller_pose(problem, result), problem.T_target_source);
    oracle_error += synth::rotation_error_deg(synth::oracle(problem), problem.T_target_source);
    plain_error += synth::rotation_error_deg(plain_fit(problem), problem.T_target_source);
    EXPECT_GT(synth::inlier_quality(problem, result.members).recall, 0.95) << "seed " << seed;
  }
  // The printed weight g^2 / (g^2 + e) with its early stop leaves outliers more weight.
  EXPECT_LT(error, (GetParam() == Rule::scale_free ? 1.3 : 6.0) * oracle_error);
  EXPECT_LT(error, plain_error / 10.0);
}

TEST_P(SaCauchyIrls, DegenerateMembersAreNotDetermined) {
  const std::vector<Eigen::Vector3d> line{{0.0, 0.0, 0.0}, {1.0, 2.0, 3.0}, {2.0, 4.0, 6.0}, {4.0, 8.0, 12.0}};
  const std::vector<Eigen::Vector3d> coincident(5, Eigen::Vector3d(1.0, 2.0, 3.0));
  const RigidTransform truth = motion(1.0, {1.0, 0.0, 0.0}, {1.0, 2.0, 3.0});
  for (const auto& points : {line, coincident}) {
    const IrlsResult result = run(perfect_problem(points, truth), GetParam(), 0.1);
    EXPECT_FALSE(result.fit.determined());
    EXPECT_TRUE(result.fit.pose.matrix().allFinite());
  }
  const IrlsResult nothing =
      sa_cauchy_irls(perfect_problem(line, truth).correspondences(), {}, {.rule = GetParam(), .final_scale = 0.1});
  EXPECT_FALSE(nothing.fit.determined());
  EXPECT_TRUE(nothing.members.empty());
}

TEST_P(SaCauchyIrls, UsesOnlyTheGivenMembers) {
  const Problem problem = synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.5, .sigma = 0.0});
  const std::vector<std::uint32_t> members = true_inliers(problem);
  const IrlsResult result =
      sa_cauchy_irls(problem.correspondences(), members, {.rule = GetParam(), .final_scale = 0.1});
  EXPECT_LT(synth::rotation_error_deg(caller_pose(problem, result), problem.T_target_source), 1e-4);
  for (const std::uint32_t k : result.members) EXPECT_TRUE(std::ranges::binary_search(members, k)) << k;
}

TEST(SaCauchyIrlsScale, OnlyScaleFreeIsTheSameInEveryUnit) {
  const Problem metres = synth::noise_study_problem({.correspondences = 100, .outlier_ratio = 0.1, .sigma = 0.1});
  const Problem millimetres = in_units(metres, 1000.0);
  const IrlsResult in_m = run(metres, Rule::scale_free, 0.3);
  const IrlsResult in_mm = run(millimetres, Rule::scale_free, 300.0);
  EXPECT_EQ(in_m.rounds, in_mm.rounds);
  EXPECT_EQ(in_m.members, in_mm.members);
  EXPECT_LT(synth::rotation_error_deg(caller_pose(metres, in_m), caller_pose(millimetres, in_mm)), 1e-5);
  EXPECT_NE(run(metres, Rule::as_printed, 0.0).rounds, run(millimetres, Rule::as_printed, 0.0).rounds);
}

TEST(SaCauchyIrlsScale, ScaleFreeStopsAtTheFinalScale) {
  const Problem problem = synth::noise_study_problem({.correspondences = 100, .outlier_ratio = 0.1, .sigma = 0.1});
  const RigidTransform start = plain_fit(problem);
  double largest = 0.0;
  for (const std::uint32_t k : all_rows(problem)) largest = std::max(largest, residual(problem, start, k));
  for (const double final_scale : {0.3, 3.0}) {
    // g starts at the largest residual and is divided by 1.3 a round while that leaves it at final_scale or more.
    const double rounds = std::floor(std::log(largest / final_scale) / std::log(1.3)) + 1.0;
    EXPECT_EQ(run(problem, Rule::scale_free, final_scale).rounds, static_cast<std::uint32_t>(rounds));
  }
}

TEST(SaCauchyIrlsOptions, BadOnesAreRejected) {
  const Problem problem = synth::noise_study_problem({.correspondences = 10});
  const auto run_with = [&](const SaCauchyIrlsOptions& options) {
    return [&, options] { static_cast<void>(sa_cauchy_irls(problem.correspondences(), all_rows(problem), options)); };
  };
  for (const double scale : kBadLengths) expect_rejected(run_with({.final_scale = scale}), "final_scale", scale);
  for (const double divisor : {1.0, 0.5, -2.0, kNan}) {
    for (const Rule rule : {Rule::scale_free, Rule::as_printed}) {
      expect_rejected(run_with({.rule = rule, .final_scale = 1.0, .scale_divisor = divisor}), "scale_divisor", divisor);
    }
  }
  EXPECT_NO_THROW(run_with({.rule = Rule::as_printed})()) << "the printed rule has no final scale";
}

}  // namespace
}  // namespace test
}  // namespace consimd
