// The default TCF on the noise study, held against a truth that it cannot know.
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <ostream>
#include <string>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

TcfOptions with_bound(double noise_bound, std::uint64_t seed = 1) {
  TcfOptions options;
  options.noise_bound = noise_bound;
  options.seed = seed;
  return options;
}

struct Cell {
  double outlier_ratio;
  double sigma;
};

void PrintTo(const Cell& cell, std::ostream* out) { *out << cell.outlier_ratio << " outliers, sigma " << cell.sigma; }

class TcfNoiseStudy : public ::testing::TestWithParam<Cell> {};
INSTANTIATE_TEST_SUITE_P(Cells, TcfNoiseStudy,
                         ::testing::Values(Cell{0.0, 1.0}, Cell{0.1, 0.1}, Cell{0.1, 5.0}, Cell{0.5, 0.1},
                                           Cell{0.5, 1.0}, Cell{0.5, 5.0}, Cell{0.9, 0.1}, Cell{0.9, 1.0},
                                           Cell{0.9, 5.0}, Cell{0.95, 0.1}, Cell{0.95, 2.5}, Cell{0.95, 5.0},
                                           Cell{0.98, 0.1}, Cell{0.98, 1.0}, Cell{0.98, 5.0}, Cell{0.99, 0.1},
                                           Cell{0.99, 1.0}));

TEST_P(TcfNoiseStudy, FindsEveryPoseAtTheOraclesError) {
  const auto [outlier_ratio, sigma] = GetParam();
  const double bound = synth::noise_study_bound(sigma);
  Errors errors;
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Problem problem =
        synth::noise_study_problem({.outlier_ratio = outlier_ratio, .sigma = sigma, .seed = 42, .trial = trial});
    const Registration result = register_tcf(problem.correspondences(), with_bound(bound, trial));
    expect_sound(result, problem, bound);
    EXPECT_EQ(result.status, Status::success);
    EXPECT_LT(synth::rmse_true_inliers(problem, result.T_target_source), bound);
    EXPECT_LT(result.log10_false_poses, -3.0);
    errors.add(problem, result.T_target_source);

    // 97 % of a Gaussian's residuals are below 3 sigma.
    const synth::InlierQuality quality = synth::inlier_quality(problem, result.inliers);
    EXPECT_GT(quality.recall, 0.85);
    EXPECT_GT(quality.precision, outlier_ratio * sigma > 4.0 ? 0.7 : 0.85);
  }
  if (kAllTrials) errors.expect_within(1.2);
}

TEST(TcfAccuracy, StagesAreReportedInOrder) {
  const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.95});
  const Registration result = register_tcf(problem.correspondences(), with_bound(3.0, 5));
  std::vector<std::string> names;
  for (const StageReport& stage : result.stages) {
    names.push_back(stage.name);
    EXPECT_GT(stage.iterations, 0u) << stage.name;
    EXPECT_GT(stage.output, 0u) << stage.name;
  }
  EXPECT_EQ(names, (std::vector<std::string>{"one_point", "two_point", "three_point", "refinement"}));
  EXPECT_EQ(result.stages.front().input, problem.size());
  EXPECT_EQ(result.stages.back().output, result.inliers.size());
  EXPECT_EQ(result.seed, 5u);
}

class TcfBound : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Factors, TcfBound, ::testing::Values(0.5, 2.0));

TEST_P(TcfBound, MayBeOffByTwo) {
  Errors errors;
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.95, .sigma = 1.0, .trial = trial});
    const Registration result = register_tcf(problem.correspondences(), with_bound(3.0 * GetParam()));
    expect_sound(result, problem, 3.0 * GetParam());
    EXPECT_EQ(result.status, Status::success) << "trial " << trial;
    errors.add(problem, result.T_target_source);
  }
  if (kAllTrials) errors.expect_within(1.2);
}

/// Harder than the study in one way each. Every pose must be found, up to the ratio of outliers where that is told.
struct HardCase {
  std::string name;
  synth::HardProblemOptions options;
  std::vector<double> outlier_ratios = {0.0, 0.5, 0.9, 0.95, 0.98};
  double error_ratio = 1.2;  ///< largest, of all trials' errors to the oracle's; ten trials of it scatter by a tenth
};

void PrintTo(const HardCase& hard, std::ostream* out) { *out << hard.name; }

class TcfHardProblem : public ::testing::TestWithParam<HardCase> {};
INSTANTIATE_TEST_SUITE_P(
    Cases, TcfHardProblem,
    ::testing::Values(
        HardCase{"permuted", {.outliers = synth::OutlierModel::permuted}},
        // From 95 % on three clusters laid onto three have more support than the truth.
        HardCase{"clustered", {.outliers = synth::OutlierModel::clustered}, {0.0, 0.5, 0.9, 0.95}},
        HardCase{"wide_clusters",
                 {.outliers = synth::OutlierModel::clustered, .clusters = 3, .cluster_sigma = 6.0},
                 {0.5, 0.9, 0.95}},
        HardCase{"clustered_little_noise", {.sigma = 0.1, .outliers = synth::OutlierModel::clustered}},
        HardCase{"many_clusters", {.outliers = synth::OutlierModel::clustered, .clusters = 50}, {0.0, 0.5, 0.9, 0.95}},
        HardCase{"one_to_many", {.outliers = synth::OutlierModel::one_to_many}},
        HardCase{"many_to_many", {.outliers = synth::OutlierModel::many_to_many}},
        // A second motion needs outliers that follow it.
        HardCase{"decoy_of_half", {.decoy_share = 0.5}, {0.5, 0.8, 0.9, 0.95, 0.98}},
        HardCase{"planar", {.scene = synth::Scene::planar, .thickness = 1.0}},
        HardCase{"planar_little_noise", {.sigma = 0.1, .scene = synth::Scene::planar}},
        HardCase{"plane_permuted",
                 {.scene = synth::Scene::planar, .thickness = 0.0, .outliers = synth::OutlierModel::permuted}},
        HardCase{"linear", {.scene = synth::Scene::linear, .thickness = 10.0}},
        HardCase{"linear_little_noise", {.sigma = 0.1, .scene = synth::Scene::linear, .thickness = 2.0}},
        HardCase{"linear_permuted",
                 {.scene = synth::Scene::linear, .thickness = 50.0, .outliers = synth::OutlierModel::permuted}},
        HardCase{"range_dependent", {.noise = synth::NoiseModel::range_dependent}},
        // Least squares, the oracle, is not the best there is for heavy tails.
        HardCase{"student_t", {.noise = synth::NoiseModel::student_t}, {0.0, 0.5, 0.9, 0.95, 0.98}, 1.0},
        HardCase{"duplicates", {.duplicates = 500}}, HardCase{"every_row_twice", {.duplicates = 2000}},
        HardCase{"quantised", {.sigma = 0.2, .quantum = 0.5}}, HardCase{"coarsely_quantised", {.quantum = 2.0}},
        HardCase{"map_coordinates", {.source_offset = {5e6, -4e6, 300.0}, .target_offset = {-4e6, 5e6, 100.0}}},
        HardCase{"millimetres", {.units_per_metre = 1000.0}},
        HardCase{"map_coordinates_in_millimetres",
                 {.sigma = 0.1,
                  .source_offset = {5e6, -4e6, 300.0},
                  .target_offset = {-4e6, 5e6, 100.0},
                  .units_per_metre = 1000.0}}),
    [](const auto& test) { return test.param.name; });

TEST_P(TcfHardProblem, IsSolved) {
  for (const double outlier_ratio : GetParam().outlier_ratios) {
    Errors errors;
    for (std::uint64_t trial = 0; trial < 10; ++trial) {
      SCOPED_TRACE(::testing::Message() << outlier_ratio << " outliers, trial " << trial);
      synth::HardProblemOptions options = GetParam().options;
      options.correspondences = 2000;
      options.outlier_ratio = outlier_ratio;
      options.trial = trial;
      const Problem problem = synth::hard_problem(options);
      // Quantised coordinates add the rounding of both clouds to the noise.
      const double sigma = std::hypot(problem.sigma, options.quantum / std::sqrt(6.0));
      const Registration result = register_tcf(problem.correspondences(), with_bound(3.0 * sigma));
      expect_sound(result, problem, 3.0 * sigma);
      EXPECT_EQ(result.status, Status::success);
      if (!result.has_pose()) continue;
      EXPECT_LT(displacement(problem, result.T_target_source, problem.T_target_source), sigma);
      // 97 % of a Gaussian's residuals are below 3 sigma.
      EXPECT_GT(synth::inlier_quality(problem, result.inliers).recall, 0.85);
      errors.add(problem, result.T_target_source);
    }
    SCOPED_TRACE(::testing::Message() << outlier_ratio << " outliers");
    errors.expect_within(GetParam().error_ratio);
  }
}

}  // namespace
}  // namespace consimd::test
