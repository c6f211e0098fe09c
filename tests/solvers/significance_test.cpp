#include <consimd/solvers/significance.hpp>

#include <consimd/solvers/one_point_ransac.hpp>
#include <consimd/solvers/three_point_ransac.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <string>
#include <tuple>

#include "outlier_models.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

double significance_of_truth(const Problem& problem, double noise_bound) {
  const Correspondences correspondences = problem.correspondences();
  const WorkingPose truth = to_working_pose(to_working_frame(problem.T_target_source, correspondences));
  return significance(correspondences, truth, noise_bound).log10_false_poses;
}

class SignificanceOfTruth : public ::testing::TestWithParam<std::tuple<double, double>> {};
INSTANTIATE_TEST_SUITE_P(Cells, SignificanceOfTruth,
                         ::testing::Combine(::testing::Values(0.1, 0.5, 0.9, 0.98), ::testing::Values(0.1, 1.0, 5.0)));

TEST_P(SignificanceOfTruth, IsBeyondDoubt) {
  const auto [outlier_ratio, sigma] = GetParam();
  for (std::uint64_t trial = 0; trial < 5; ++trial) {
    const Problem problem =
        synth::noise_study_problem({.outlier_ratio = outlier_ratio, .sigma = sigma, .trial = trial});
    EXPECT_LT(significance_of_truth(problem, 3.0 * sigma), -15.0) << "trial " << trial;
  }
}

TEST(Significance, GrowsWithTheNumberOfInliers) {
  double previous = 0.0;
  for (const double outlier_ratio : {0.99, 0.98, 0.95, 0.9, 0.5}) {
    const double value = significance_of_truth(synth::noise_study_problem({.outlier_ratio = outlier_ratio}), 3.0);
    EXPECT_LT(value, previous) << outlier_ratio;
    previous = value;
  }
}

TEST(Significance, IsTheSameInEveryUnit) {
  const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.98, .sigma = 1.0});
  const double in_metres = significance_of_truth(problem, 3.0);
  for (const double factor : {1e-3, 1e3, 1e6}) {
    EXPECT_NEAR(significance_of_truth(in_units(problem, factor), 3.0 * factor), in_metres, 0.02 * -in_metres);
  }
}

class SignificanceByChance : public ::testing::TestWithParam<synth::OutlierModel> {};
INSTANTIATE_TEST_SUITE_P(OutlierModels, SignificanceByChance, ::testing::ValuesIn(kOutlierModels),
                         [](const auto& test) { return std::string(name_of(test.param)); });

TEST_P(SignificanceByChance, BestPosesWithoutATruthAreNotSignificant) {
  // The expected number of problems whose best pose comes below -1 is a tenth of their number at most, and below -2 a
  // hundredth: of these 40, more than 10 and more than 2 would have chances under 0.2 % and 1 %.
  int below_one = 0;
  int below_two = 0;
  for (std::uint64_t trial = 0; trial < 40; ++trial) {
    const Problem problem =
        synth::hard_problem({.correspondences = 500, .outlier_ratio = 1.0, .trial = trial, .outliers = GetParam()});
    const Correspondences correspondences = problem.correspondences();
    double least = 0.0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const ConsensusSet set =
          one_point_ransac(correspondences, {.consistency_bound = 6.0, .max_iterations = 200, .seed = seed});
      const ThreePointResult result =
          three_point_ransac(correspondences, set.members, {.noise_bound = 3.0, .max_iterations = 500, .seed = seed});
      least = std::min(least, significance(correspondences, to_working_pose(result.pose), 3.0).log10_false_poses);
    }
    if (least < -1.0) ++below_one;
    if (least < -2.0) ++below_two;
  }
  EXPECT_LE(below_one, 10);
  EXPECT_LE(below_two, 2);
}

TEST(Significance, APoseWithoutSupportHasNone) {
  const Problem problem = synth::noise_study_problem({.correspondences = 1000});
  const Correspondences correspondences = problem.correspondences();
  const RigidTransform far = motion(2.0, {1.0, 2.0, 0.0}, {1e4, 0.0, 0.0});
  const double value =
      significance(correspondences, to_working_pose(to_working_frame(far, correspondences)), 3.0).log10_false_poses;
  EXPECT_GE(value, 0.0);
  EXPECT_LE(value, std::log10(1000.0 * 999.0 * 998.0 / 6.0) + 1.0);
}

TEST(Significance, FewerThanThreeCorrespondencesHaveNone) {
  for (std::size_t n = 1; n < 3; ++n) {
    const Problem problem = synth::noise_study_problem({.correspondences = n, .outlier_ratio = 0.0, .sigma = 0.0});
    EXPECT_GE(significance_of_truth(problem, 1.0), 0.0);
  }
  EXPECT_GE(significance(Correspondences(), to_working_pose(RigidTransform::Identity()), 1.0).log10_false_poses, 0.0);
}

TEST(Significance, RejectsBadBounds) {
  const Problem problem = synth::noise_study_problem({.correspondences = 10});
  for (const double bound : kBadLengths) {
    expect_rejected([&] { static_cast<void>(significance_of_truth(problem, bound)); }, "noise_bound", bound);
  }
}

}  // namespace
}  // namespace consimd::test
