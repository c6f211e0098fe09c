// The covariance of a pose against the errors of many trials: d^T C^-1 d of six components that are distributed as C
// says has the mean 6 (the normalised estimation error squared, NEES).
#include <consimd/solvers/pose_covariance.hpp>

#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <Eigen/Eigenvalues>

#include <numbers>
#include <ostream>
#include <random>
#include <string>

#include "pose_errors.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

/// Refined from the true pose, off by about a noise bound at the rim of the scene.
RefinedPose refine(const Problem& problem, const Correspondences& correspondences, double noise_bound) {
  const double angle = noise_bound * correspondences.scale();
  RigidTransform offset = motion(angle, {1.0, -2.0, 3.0}, Eigen::Vector3d::Constant(noise_bound / 4.0));
  const Eigen::Vector3d centre(correspondences.source_centroid().data());
  offset.translation() += centre - offset.linear() * centre;
  const RigidTransform start = to_working_frame(problem.T_target_source * offset, correspondences);
  return refine_pose(correspondences, to_working_pose(start), {.noise_bound = noise_bound});
}

NormalisedErrors normalised_errors(synth::HardProblemOptions options, double bound_factor = 1.0) {
  NormalisedErrors errors;
  for (std::uint64_t trial = 0; trial < trials(300); ++trial) {
    options.trial = trial;
    const Problem problem = synth::hard_problem(options);
    const Correspondences correspondences = problem.correspondences();
    const RefinedPose refined =
        refine(problem, correspondences, bound_factor * synth::noise_study_bound(problem.sigma));
    errors.add(to_caller_frame(refined.fit.pose, correspondences), problem.T_target_source, refined.covariance);
  }
  return errors;
}

class StudyCell : public ::testing::TestWithParam<std::tuple<double, double>> {};
INSTANTIATE_TEST_SUITE_P(Cells, StudyCell,
                         ::testing::Combine(::testing::Values(0.1, 0.5, 0.9, 0.95, 0.98),
                                            ::testing::Values(0.1, 1.0, 2.5, 5.0)));

TEST_P(StudyCell, ErrorsAreDistributedAsTheCovarianceSays) {
  const auto [outlier_ratio, sigma] = GetParam();
  const NormalisedErrors errors = normalised_errors({.outlier_ratio = outlier_ratio, .sigma = sigma, .seed = 77});
  if (!kAllTrials) return;
  EXPECT_NEAR(errors.nees(), 6.0, 0.6);  // the deviation of the mean of 300 is 0.2
}

struct Variation {
  std::string name;
  synth::HardProblemOptions options;
  double bound_factor = 1.0;
  double limit = 0.6;  ///< on the deviation of the NEES from 6
};

void PrintTo(const Variation& variation, std::ostream* out) { *out << variation.name; }

class HardCell : public ::testing::TestWithParam<Variation> {};
INSTANTIATE_TEST_SUITE_P(
    Variations, HardCell,
    ::testing::Values(
        // Shapes and lever arms that would show a wrong frame or a wrong sign.
        Variation{"linear_off_centre",
                  {.scene = synth::Scene::linear, .thickness = 20.0, .source_offset = {300, -200, 100}}},
        Variation{"planar_off_centre", {.scene = synth::Scene::planar, .source_offset = {300, -200, 100}}},
        Variation{"millimetres", {.units_per_metre = 1000.0}},
        Variation{"permuted", {.outliers = synth::OutlierModel::permuted}},
        Variation{"many_to_many", {.outliers = synth::OutlierModel::many_to_many}},
        Variation{"student_t", {.noise = synth::NoiseModel::student_t}},
        Variation{"student_t_98", {.outlier_ratio = 0.98, .noise = synth::NoiseModel::student_t}},
        Variation{"range_dependent", {.noise = synth::NoiseModel::range_dependent}, 1.0, 1.2},
        Variation{"half_the_bound", {}, 0.5}, Variation{"half_the_bound_98", {.outlier_ratio = 0.98}, 0.5, 1.5},
        Variation{"twice_the_bound", {}, 2.0},
        Variation{"twice_the_bound_98", {.outlier_ratio = 0.98, .sigma = 5.0}, 2.0},
        Variation{"ten_times_the_bound", {.sigma = 0.1}, 10.0},
        Variation{"ten_inliers", {.correspondences = 100}, 1.0, 1.2}),
    [](const auto& test) { return test.param.name; });

TEST_P(HardCell, ErrorsAreDistributedAsTheCovarianceSays) {
  synth::HardProblemOptions options = GetParam().options;
  options.seed = 78;
  const NormalisedErrors errors = normalised_errors(options, GetParam().bound_factor);
  if (!kAllTrials) return;
  EXPECT_NEAR(errors.nees(), 6.0, GetParam().limit);
  // No component makes up for another; the deviation of each mean is 0.08.
  EXPECT_GT(errors.mean_squares().minCoeff(), 0.7);
  EXPECT_LT(errors.mean_squares().maxCoeff(), 1.0 + GetParam().limit / 2.0);
}

/// Targets of inliers moved by a smooth random field of that deviation per axis, whose correlation falls with the
/// distance d as exp(-d^2 / (2 reach^2)): what a bent scan or a drifting sensor does to neighbours.
Problem with_shared_errors(Problem problem, double deviation, double reach, std::uint64_t seed) {
  constexpr int kWaves = 64;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  const auto vector = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  for (int wave = 0; wave < kWaves; ++wave) {
    const Eigen::Vector3d wavenumber = vector() / reach;
    const Eigen::Vector3d amplitude = deviation * std::sqrt(2.0 / kWaves) * vector();
    const double shift = phase(random);
    for (std::size_t k = 0; k < problem.size(); ++k) {
      if (problem.is_inlier[k] == 0) continue;
      Eigen::Map<Eigen::Vector3d>(&problem.target[3 * k]) +=
          amplitude * std::cos(wavenumber.dot(source_point(problem, k)) + shift);
    }
  }
  return problem;
}

class SharedErrors : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Reaches, SharedErrors, ::testing::Values(10.0, 25.0, 50.0));

TEST_P(SharedErrors, AreCounted) {
  // Scenes of 200 m. Half of the variance is shared.
  NormalisedErrors errors;
  for (std::uint64_t trial = 0; trial < trials(100); ++trial) {
    const Problem problem =
        with_shared_errors(synth::noise_study_problem({.outlier_ratio = 0.7, .sigma = 1.0, .seed = 80, .trial = trial}),
                           1.0, GetParam(), trial);
    const Correspondences correspondences = problem.correspondences();
    const RefinedPose refined = refine(problem, correspondences, synth::noise_study_bound(std::sqrt(2.0)));
    errors.add(to_caller_frame(refined.fit.pose, correspondences), problem.T_target_source, refined.covariance);
  }
  if (!kAllTrials) return;
  // It is 5.5, 6.2 and 7.9 (5.35 if C is right).
  EXPECT_GT(errors.median_nees(), 4.0);
  EXPECT_LT(errors.median_nees(), 10.0);
}

TEST(TcfCovariance, ErrorsAreDistributedAsTheCovarianceSays) {
  NormalisedErrors errors;
  for (const double outlier_ratio : {0.1, 0.5, 0.9, 0.95, 0.98}) {
    for (const double sigma : {0.1, 5.0}) {
      for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
        const Problem problem =
            synth::noise_study_problem({.outlier_ratio = outlier_ratio, .sigma = sigma, .seed = 79, .trial = trial});
        const Registration result =
            register_tcf(problem.correspondences(), {.noise_bound = synth::noise_study_bound(sigma), .seed = trial});
        ASSERT_TRUE(result.has_pose());
        errors.add(result.T_target_source, problem.T_target_source, result.covariance);
      }
    }
  }
  if (!kAllTrials) return;
  EXPECT_NEAR(errors.nees(), 6.0, 0.75);  // the deviation of the mean of 200 is 0.25
}

TEST(PoseCovariance, IsThatOfLeastSquaresWithoutOutliers) {
  constexpr double kSigma = 0.5;
  const Problem problem = synth::hard_problem(
      {.outlier_ratio = 0.0, .sigma = kSigma, .scene = synth::Scene::planar, .source_offset = {30.0, 20.0, -400.0}});
  const RefinedPose refined = refine(problem, problem.correspondences(), 3.0 * kSigma);
  Matrix6d information = Matrix6d::Zero();
  for (std::size_t k = 0; k < problem.size(); ++k) {
    Eigen::Matrix<double, 3, 6> jacobian;
    jacobian << -cross(problem.T_target_source.linear() * source_point(problem, k)), Eigen::Matrix3d::Identity();
    information += jacobian.transpose() * jacobian / (kSigma * kSigma);
  }
  const Matrix6d L = Eigen::LLT<Matrix6d>(information).matrixL();
  EXPECT_LT((L.transpose() * refined.covariance * L - Matrix6d::Identity()).norm(), 0.06);
}

TEST(PoseCovariance, IsZeroWhereThereIsNoPose) {
  const Problem chance = synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 1.0});
  const Problem few = synth::noise_study_problem({.correspondences = 2, .outlier_ratio = 0.0});
  for (const Problem* problem : {&chance, &few}) {
    const Registration result = register_tcf(problem->correspondences(), {.noise_bound = 3.0});
    ASSERT_FALSE(result.has_pose());
    EXPECT_TRUE(result.covariance.isZero(0.0));
  }
  const Problem far = with_moved_target(chance, motion(3.0, {1.0, 0.0, 0.0}, {1e4, 0.0, 0.0}));
  const Correspondences correspondences = far.correspondences();
  const RigidTransform start = to_working_frame(chance.T_target_source, correspondences);
  EXPECT_TRUE(refine_pose(correspondences, to_working_pose(start), {.noise_bound = 0.1}).covariance.isZero(0.0));
}

/// One problem and its covariance; other forms of the same problem must have the same.
class PoseCovarianceInvariance : public ::testing::Test {
 protected:
  static Matrix6d covariance(const Problem& problem, double unit = 1.0) {
    Matrix6d result = refine(problem, problem.correspondences(), 3.0 * unit).covariance;
    EXPECT_EQ(result, result.transpose());
    const Vector6d deviations = result.diagonal().cwiseSqrt();
    const Matrix6d correlation =
        deviations.cwiseInverse().asDiagonal() * result * deviations.cwiseInverse().asDiagonal();
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(correlation).eigenvalues()[0], -1e-14);
    return result;
  }

  void expect_same(const Matrix6d& other) const {
    const Eigen::LLT<Matrix6d> factors(reference_);
    const Matrix6d whitened = factors.matrixL().solve(factors.matrixL().solve(other).transpose());
    EXPECT_LT((whitened - Matrix6d::Identity()).norm(), 0.01) << whitened;
  }

  Problem problem_ = synth::noise_study_problem({.outlier_ratio = 0.9, .sigma = 1.0});
  Matrix6d reference_ = covariance(problem_);
};

TEST_F(PoseCovarianceInvariance, OrderOfRows) {
  expect_same(covariance(chosen_rows(problem_, random_order(problem_.size(), 1))));
}

TEST_F(PoseCovarianceInvariance, Unit) {
  for (const double factor : {1e-3, 1e3, 1e20}) {
    Vector6d units;
    units << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(1.0 / factor);
    expect_same(units.asDiagonal() * covariance(in_units(problem_, factor), factor) * units.asDiagonal());
  }
}

TEST_F(PoseCovarianceInvariance, MapCoordinates) {
  const Eigen::Vector3d offset(5e6, -4e6, 300.0);
  Problem shifted = problem_;
  for (std::size_t k = 0; k < shifted.size(); ++k) Eigen::Map<Eigen::Vector3d>(&shifted.source[3 * k]) += offset;
  shifted.T_target_source.translation() -= problem_.T_target_source.linear() * offset;
  shifted = with_moved_target(shifted, motion(0.0, {1.0, 0.0, 0.0}, {4e6, 5e6, -100.0}));
  // Back to the image of the offset, where the error is dt - [R offset]x theta.
  Matrix6d back = Matrix6d::Identity();
  const Correspondences correspondences = shifted.correspondences();
  const RigidTransform estimate = to_caller_frame(refine(shifted, correspondences, 3.0).fit.pose, correspondences);
  back.bottomLeftCorner<3, 3>() = -cross(estimate.linear() * offset);
  expect_same(back * covariance(shifted) * back.transpose());
}

TEST_F(PoseCovarianceInvariance, MotionOfTheTarget) {
  const RigidTransform moved = motion(2.0, {1.0, -2.0, 0.5}, {10.0, 20.0, -30.0});
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = moved.linear().transpose();
  expect_same(turn * covariance(with_moved_target(problem_, moved)) * turn.transpose());
}

}  // namespace
}  // namespace consimd::test
