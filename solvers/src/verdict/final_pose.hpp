// What solvers share around their search: the best pose refined, tested and turned into a registration.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_covariance.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/significance.hpp>

#include "support/best_poses.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {

struct FinalPose {
  RigidTransform pose = RigidTransform::Identity();  ///< working frame
  std::vector<std::uint32_t> inliers;
  double rotation_deviation = 0.0;
  double sigma = 0.0;  ///< of a residual per axis, caller's unit
  double log10_false_poses = 0.0;
  std::uint32_t rounds = 0;
  bool was_runner_up = false;  ///< or else another than the best pose of the search
  PoseCovariance covariance = PoseCovariance::Zero();
  double scale = 1.0;            ///< of the sources, that would fit the supporters best
  double scale_deviation = 0.0;  ///< if the scale was unknown, relative to it
  double shared_errors = 1.0;    ///< what errors that supporters share multiply its square by
  Eigen::Matrix<double, 3, 1, Eigen::DontAlign> centre =
      Eigen::Matrix<double, 3, 1, Eigen::DontAlign>::Zero();  ///< of the supporters' sources, working frame
};

/// What `finish` does to a pose before it is tested.
enum class Refinement : std::uint8_t {
  full,  ///< maximum likelihood over all correspondences
  none,  ///< nothing: for solvers whose own estimate is asked for. No covariance then
};

/// Refines the best pose and measures its significance. `glance`: what a glance said of it, if that left no doubt.
/// Otherwise the runner-up is tested as well and becomes the best pose if it is more significant.
FinalPose finish(const Correspondences& correspondences, const PoseTest& test, BestPoses& poses,
                 Refinement refinement = Refinement::full, const std::optional<Significance>& glance = std::nullopt);

/// Fills the status and all that belongs to the pose. `final`: of poses.best(), or as constructed if there is none.
/// `set`: rows that agree in length, from which the best pose of the search came. `confident`: the search did not end
/// early.
void conclude(const Correspondences& correspondences, const PoseTest& test, const BestPoses& poses,
              const std::vector<std::uint32_t>& set, const FinalPose& final, bool confident, Registration& result);

/// Both for searches other than the default. Adds the stage "refinement" to the report, or "significance" if nothing is
/// refined: the status is `ambiguous` then where a pose near by has more than five fourths of the supporters. At least
/// three correspondences.
void finish_and_conclude(const Correspondences& correspondences, const PoseTest& test, BestPoses poses,
                         const std::vector<std::uint32_t>& set, bool confident, Registration& result,
                         Refinement refinement = Refinement::full);

}  // namespace consimd::detail
