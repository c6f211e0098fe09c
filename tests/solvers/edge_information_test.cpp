// Information matrices of pose graphs, each under the error function of its library.
#include <consimd/solvers/edge_information.hpp>

#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <array>
#include <stdexcept>

#include "pose_errors.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

constexpr std::array kLibraries{PoseGraphLibrary::gtsam, PoseGraphLibrary::g2o, PoseGraphLibrary::open3d};

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

/// Logarithm on SE(3), rotation first.
Vector6d gtsam_error(const RigidTransform& difference) {
  const Eigen::Vector3d w = rotation_vector(difference.linear());
  const double angle = w.norm();
  const Eigen::Matrix3d W = cross(w);
  // The inverse of the left Jacobian of the rotation takes the translation to its part of the logarithm.
  const double b = angle > 1e-5 ? (1.0 - angle / (2.0 * std::tan(angle / 2.0))) / (angle * angle) : 1.0 / 12.0;
  const Eigen::Vector3d t = difference.translation();
  Vector6d error;
  error << w, t - 0.5 * (W * t) + b * (W * (W * t));
  return error;
}

Vector6d g2o_error(const RigidTransform& difference) {
  Eigen::Quaterniond q(difference.linear());
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  Vector6d error;
  error << difference.translation(), q.vec();
  return error;
}

Vector6d open3d_error(const RigidTransform& difference) {
  const Eigen::Matrix4d m = difference.matrix();
  Vector6d error;
  error << (m(2, 1) - m(1, 2)) / 2.0, (m(0, 2) - m(2, 0)) / 2.0, (m(1, 0) - m(0, 1)) / 2.0, m(0, 3), m(1, 3), m(2, 3);
  return error;
}

Vector6d library_error(PoseGraphLibrary library, const RigidTransform& estimate, const RigidTransform& truth) {
  const RigidTransform difference = estimate.inverse() * truth;
  switch (library) {
    case PoseGraphLibrary::gtsam:
      return gtsam_error(difference);
    case PoseGraphLibrary::g2o:
      return g2o_error(difference);
    case PoseGraphLibrary::open3d:
      break;
  }
  return open3d_error(difference);
}

TEST(EdgeInformation, ErrorsOfEachLibraryAreDistributedAsItSays) {
  // A slab beside its origin: a wrong order, side or frame shows. 400 trials: the mean of e^T information e deviates by
  // sqrt(12 / 400) = 0.17 from 6 if the covariance is right; the limits are four such deviations away, a false alarm in
  // 16 000 choices of the seed.
  constexpr std::uint64_t kTrials = 400;
  std::array<double, kLibraries.size()> means{};
  double as_it_comes = 0.0;  // the covariance on the left side, its inverse taken as gtsam's
  double other_order = 0.0;  // gtsam's taken as g2o's
  for (std::uint64_t trial = 0; trial < trials(kTrials); ++trial) {
    const Problem problem = synth::hard_problem({.correspondences = 500,
                                                 .outlier_ratio = 0.5,
                                                 .sigma = 0.5,
                                                 .seed = 81,
                                                 .trial = trial,
                                                 .scene = synth::Scene::planar,
                                                 .thickness = 10.0,
                                                 .source_offset = {200.0, -100.0, 50.0}});
    const Correspondences correspondences = problem.correspondences();
    const RigidTransform start = to_working_frame(problem.T_target_source, correspondences);
    const RefinedPose refined =
        refine_pose(correspondences, to_working_pose(start), {.noise_bound = synth::noise_study_bound(0.5)});
    const RigidTransform pose = to_caller_frame(refined.fit.pose, correspondences);
    for (std::size_t k = 0; k < kLibraries.size(); ++k) {
      const Matrix6d information = edge_information(pose, refined.covariance, kLibraries[k]);
      ASSERT_EQ(information, information.transpose());
      const Vector6d error = library_error(kLibraries[k], pose, problem.T_target_source);
      means[k] += error.dot(information * error) / trials(kTrials);
    }
    const Vector6d gtsam = gtsam_error(pose.inverse() * problem.T_target_source);
    const Vector6d g2o = g2o_error(pose.inverse() * problem.T_target_source);
    as_it_comes += gtsam.dot(Matrix6d(refined.covariance).llt().solve(gtsam)) / trials(kTrials);
    other_order += g2o.dot(edge_information(pose, refined.covariance, PoseGraphLibrary::gtsam) * g2o) / trials(kTrials);
  }
  if (!kAllTrials) return;
  for (const double mean : means) EXPECT_NEAR(mean, 6.0, 0.7);
  EXPECT_GT(as_it_comes, 12.0);
  EXPECT_GT(other_order, 12.0);
}

TEST(EdgeInformation, OfAKnownCovariance) {
  // A quarter turn about z: x of the target frame is -y of the source frame.
  RigidTransform pose = RigidTransform::Identity();
  pose.linear() = Eigen::AngleAxisd(std::acos(0.0), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(3.0, -4.0, 5.0);
  PoseCovariance covariance = PoseCovariance::Zero();
  covariance.diagonal() << 1.0, 4.0, 16.0, 0.01, 0.04, 0.25;
  Vector6d expected;
  expected << 0.25, 1.0, 0.0625, 25.0, 100.0, 4.0;
  const auto diagonal = [&](PoseGraphLibrary library) -> Vector6d {
    return edge_information(pose, covariance, library).diagonal();
  };
  EXPECT_TRUE(diagonal(PoseGraphLibrary::gtsam).isApprox(expected, 1e-12));
  EXPECT_TRUE(diagonal(PoseGraphLibrary::open3d).isApprox(expected, 1e-12));
  expected << 25.0, 100.0, 4.0, 1.0, 4.0, 0.25;
  EXPECT_TRUE(diagonal(PoseGraphLibrary::g2o).isApprox(expected, 1e-12));
}

TEST(EdgeInformation, NeedsAPositiveDefiniteCovariance) {
  const RigidTransform pose = RigidTransform::Identity();
  const Registration none;
  PoseCovariance flat = PoseCovariance::Identity();
  flat(5, 5) = 0.0;
  PoseCovariance tied = PoseCovariance::Identity();
  tied(0, 5) = tied(5, 0) = 1.0;
  PoseCovariance not_a_number = PoseCovariance::Identity();
  not_a_number(2, 2) = kNan;
  for (const PoseCovariance& covariance : {none.covariance, flat, tied, not_a_number}) {
    for (const PoseGraphLibrary library : kLibraries) {
      EXPECT_THROW((void)edge_information(pose, covariance, library), std::invalid_argument);
    }
  }
}

}  // namespace
}  // namespace consimd::test
