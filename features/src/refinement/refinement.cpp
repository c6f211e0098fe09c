#include <consimd/features/refinement.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/elementary_functions.hpp>

#include "grid/box.hpp"
#include "refinement/closest_pairs.hpp"
#include "refinement/normal_equations.hpp"
#include "refinement/refined_covariance.hpp"

namespace consimd::features {
namespace {

using detail::Matrix6d;
using detail::NormalEquations;
using detail::Vector6d;

constexpr std::array kMethods{std::pair("point", RefinementMethod::point), std::pair("plane", RefinementMethod::plane),
                              std::pair("gicp", RefinementMethod::gicp)};

// The square of the sine of five degrees, about the error of a normal of a noisy neighbourhood: what pairs tell of a
// direction is no more than their normals' errors where it is less than this share of what they tell of all three.
constexpr double kLeastShare = 0.0076;
// A step is too small to matter where it moves the points by less than this share of the residuals' deviation.
constexpr double kSmallStep = 1e-2;
constexpr std::size_t kFewestPairs = 6;
// Of clouds that leave a thousand points then, every eighth is moved until a step is below a quarter of the residuals'
// deviation: what is looked for far from the end need not be exact.
constexpr std::size_t kStride = 8;
constexpr std::size_t kFewestToThin = 8 * 1024;
constexpr double kCoarseStep = 0.25;

void check(const Cloud& source, const Cloud& target, const RigidTransform& start, const RefinementOptions& options) {
  if (options.max_distance && !(std::isfinite(*options.max_distance) && *options.max_distance > 0.0)) {
    throw std::invalid_argument("max_distance is " + std::to_string(*options.max_distance) +
                                ", expected a finite length above 0");
  }
  if (options.max_iterations < 1) throw std::invalid_argument("max_iterations is 0, expected 1 or more");
  if (!start.matrix().allFinite()) throw std::invalid_argument("the start of a refinement is not finite");
  const bool any = !source.empty() && !target.empty();
  const bool of_target = any && options.method != RefinementMethod::point;
  const bool of_source = any && options.method == RefinementMethod::gicp;
  for (const auto& [name, cloud, needed] :
       {std::tuple("target", &target, of_target), std::tuple("source", &source, of_source)}) {
    if (needed && !cloud->view().has_normals()) {
      throw std::invalid_argument(std::string("the ") + name + " cloud has no normals, which refinement by " +
                                  std::string(to_string(options.method)) + " needs: estimate them first");
    }
  }
}

/// A step of Gauss-Newton in the directions that the pairs determine.
struct Step {
  Eigen::Vector3d turn;
  Eigen::Vector3d shift;
  double size;  ///< root mean square motion of the points, working frame
  bool determined;
};

Step step_of(const NormalEquations& sums) {
  // Rotations in units in which they move the points as far as translations do.
  const double reach = std::sqrt(sums.spread / sums.weight);
  Vector6d unit;
  unit << Eigen::Vector3d::Constant(reach > 0.0 ? 1.0 / reach : 1.0), Eigen::Vector3d::Ones();
  const Matrix6d whole = sums.normal.selfadjointView<Eigen::Lower>();
  const double information = whole.bottomRightCorner<3, 3>().trace();  // of all directions together
  const Matrix6d scaled = unit.asDiagonal() * whole * unit.asDiagonal() / information;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> axes(scaled);
  const Vector6d along = axes.eigenvectors().transpose() * (unit.asDiagonal() * sums.score / information);
  Vector6d solved = Vector6d::Zero();
  bool determined = true;
  for (int k = 0; k < 6; ++k) {
    if (axes.eigenvalues()[k] > kLeastShare) {
      solved[k] = -along[k] / axes.eigenvalues()[k];
    } else {
      determined = false;
    }
  }
  const Vector6d step = axes.eigenvectors() * solved;
  return {unit[0] * step.head<3>(), step.tail<3>(), step.norm(), determined};
}

/// The motion by a step about `centre`, caller's frame of the target.
RigidTransform motion_of(const Step& step, const Eigen::Vector3d& centre, double scale) {
  const double angle = step.turn.norm();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (angle > 0.0) {
    const auto [sine, cosine] = elementary::sine_cosine(0.5 * angle);
    const Eigen::Vector3d axis = (sine / angle) * step.turn;
    rotation = Eigen::Quaterniond(cosine, axis.x(), axis.y(), axis.z()).toRotationMatrix();
  }
  RigidTransform motion = RigidTransform::Identity();
  motion.linear() = rotation;
  motion.translation() = centre + step.shift / scale - rotation * centre;
  return motion;
}

Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& rotation) {
  return Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
}

/// From (omega, tau) about a centre in the working frame to (theta, dt) of a pose.
PoseCovariance to_pose_covariance(const Matrix6d& covariance, const RigidTransform& pose, const Eigen::Vector3d& centre,
                                  double scale) {
  // dt = tau + omega x (t - centre).
  const Eigen::Vector3d arm = pose.translation() - centre;
  Matrix6d jacobian = Matrix6d::Identity();
  jacobian.bottomLeftCorner<3, 3>() << 0.0, arm[2], -arm[1], -arm[2], 0.0, arm[0], arm[1], -arm[0], 0.0;
  jacobian.bottomRightCorner<3, 3>() /= scale;
  const Matrix6d moved = jacobian * covariance * jacobian.transpose();
  return 0.5 * (moved + moved.transpose());
}

/// The mean of the moved points that have a pair, working frame.
Eigen::Vector3d centre_of(const detail::ClosestPairs& pairs, std::span<const float> squared) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!(squared[i] >= 0.0f)) continue;
    const auto& points = pairs.block(i / PairBlock::kSize).points;
    for (Eigen::Index c = 0; c < 3; ++c) sum[c] += static_cast<double>(points[c][i % PairBlock::kSize]);
    ++count;
  }
  // In single precision, in which rotations are taken about it.
  return (sum / static_cast<double>(std::max<std::size_t>(count, 1))).cast<float>().cast<double>();
}

std::vector<std::uint32_t> every(std::size_t stride, const std::vector<std::uint32_t>& rows) {
  std::vector<std::uint32_t> chosen;
  chosen.reserve(rows.size() / stride + 1);
  for (std::size_t i = 0; i < rows.size(); i += stride) chosen.push_back(rows[i]);
  return chosen;
}

/// The resolution of a cloud of any density, caller's unit; its length where all points are alone, 0 of one place.
double resolution_of(const Cloud& cloud) {
  const detail::Box box = detail::box_around(cloud);
  double length = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    length = std::max(length, static_cast<double>(box.high[c]) - static_cast<double>(box.low[c]));
  }
  length /= cloud.scale();
  // That of points spread evenly over a square, or more where most have no neighbour so near.
  for (double cell = 2.0 * length / std::sqrt(static_cast<double>(cloud.size())); cell < length; cell *= 2.0) {
    const double found = resolution(CellGrid(cloud, cell));
    if (std::isfinite(found)) return found;
  }
  return length;
}

double default_max_distance(const Cloud& source, const Cloud& target) {
  constexpr double kResolutions = 3.0;
  const double mean = (resolution_of(source) + resolution_of(target)) / 2.0;
  return mean > 0.0 ? kResolutions * mean : 1.0;
}

}  // namespace

std::string_view to_string(RefinementMethod method) noexcept {
  for (const auto& [name, value] : kMethods) {
    if (value == method) return name;
  }
  return "";
}

RefinementMethod parse_refinement_method(std::string_view name) {
  std::string names;
  for (const auto& [known, method] : kMethods) {
    if (known == name) return method;
    names += (names.empty() ? "" : ", ") + std::string(known);
  }
  throw std::invalid_argument("unknown refinement '" + std::string(name) + "', expected one of " + names);
}

std::string_view to_string(RefinementStatus status) noexcept {
  switch (status) {
    case RefinementStatus::converged:
      return "converged";
    case RefinementStatus::iteration_limit:
      return "iteration_limit";
    case RefinementStatus::degenerate_geometry:
      return "degenerate_geometry";
    case RefinementStatus::too_few_pairs:
      break;
  }
  return "too_few_pairs";
}

Refinement refine(const Cloud& source, const Cloud& target, const RigidTransform& start,
                  const RefinementOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  check(source, target, start, options);
  Refinement result;
  result.T_target_source = start;
  const auto ended = [&]() -> Refinement& {
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    return result;
  };
  if (source.empty() || target.empty()) return ended();
  result.max_distance = options.max_distance ? *options.max_distance : default_max_distance(source, target);

  // Searches reach further than pairs do, so that a point without one need not be looked for again at each small step.
  // Cells twice as wide leave one or two along each axis to look into: finding cells takes longer than a few points
  // more (0.86 of the time of two KITTI scans).
  constexpr double kReach = 1.25;
  constexpr double kCell = 2.0;
  const double reach = kReach * result.max_distance;
  const CellGrid grid(target, kCell * reach);
  const CloudView target_view = grid.cloud().view();
  const double unit = grid.cloud().scale();
  const Eigen::Vector3d origin = Eigen::Map<const Eigen::Vector3d>(grid.cloud().origin().data());
  const std::vector<std::uint32_t> rows = detail::rows_by_target_cell(source, grid, start);
  std::optional<detail::ClosestPairs> pairs;
  bool thinned = rows.size() >= kFewestToThin;
  const auto pair = [&] {
    pairs.emplace(source, thinned ? every(kStride, rows) : rows, grid, result.max_distance, reach);
    pairs->move(result.T_target_source);
  };
  const auto problem_about = [&](const Eigen::Vector3d& centre) {
    return detail::pair_problem(*pairs, options.method, result.T_target_source.linear(), centre);
  };
  pair();
  const Eigen::Vector3d centre =
      centre_of(*pairs, detail::squared_residuals(*pairs, target_view, problem_about(Eigen::Vector3d::Zero())));
  const Eigen::Vector3d caller_centre = origin + centre / unit;
  NormalEquations sums;
  for (;;) {
    PairProblem problem = problem_about(centre);
    const std::vector<float> squared = detail::squared_residuals(*pairs, target_view, problem);
    const double scale = detail::residual_scale(squared, options.method);
    if (scale > 0.0) {
      problem.scale = static_cast<float>(scale);
      sums = detail::sum_of(*pairs, target_view, problem);
    } else {
      sums = {};
    }
    result.pairs = sums.pairs;
    if (thinned && sums.pairs < kFewestPairs) {
      thinned = false;
      pair();
      continue;
    }
    if (sums.pairs < kFewestPairs) {
      result.status = RefinementStatus::too_few_pairs;
      break;
    }
    result.rmse = std::sqrt(sums.squared_length / static_cast<double>(sums.pairs)) / unit;
    result.residual_scale = scale / unit;
    const Step step = step_of(sums);
    const bool last = result.iterations + 1 == options.max_iterations;
    const bool small = !thinned && step.size <= kSmallStep * scale;
    if (small || result.iterations == options.max_iterations) {
      result.status = !step.determined ? RefinementStatus::degenerate_geometry
                      : small          ? RefinementStatus::converged
                                       : RefinementStatus::iteration_limit;
      if (result.status == RefinementStatus::converged) {
        result.shared_errors = detail::shared_error_factor(*pairs, target_view, problem, squared, sums);
        result.covariance = to_pose_covariance(result.shared_errors * detail::independent_covariance(sums),
                                               result.T_target_source, caller_centre, unit);
      }
      break;
    }
    result.T_target_source = motion_of(step, caller_centre, unit) * result.T_target_source;
    result.T_target_source.linear() = orthonormal(result.T_target_source.linear());
    ++result.iterations;
    if (thinned && (last || step.size <= kCoarseStep * scale)) {
      thinned = false;
      pair();
    } else {
      pairs->move(result.T_target_source);
    }
  }
  result.inlier_share = static_cast<double>(result.pairs) / static_cast<double>(source.size());
  return ended();
}

}  // namespace consimd::features
