#include "verdict/turned_motion.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "support/supported_motion.hpp"
#include "verdict/false_poses.hpp"
#include "verdict/kept_coordinates.hpp"

namespace consimd::detail {
namespace {

// A full turn has so many, and so many of the best are kept: at ten metres two turns are a metre apart.
constexpr std::size_t kTurns = 64;
constexpr std::size_t kMostKept = 16;
// Poses that each of them may be brought into place at: shifts and turns by a bound that lie within the three that it
// starts with. Where nothing is kept the best ones of 1000 and of 3000 uniform rows are those of so many times one to
// three where a pose reaches one row by chance, of a tenth as many where it reaches three, and of fewer beyond.
constexpr double kReached = 27.0 * 27.0;

struct Turned {
  PoseCandidate found;
  double independent = 0.0;
};

WorkingPose turned_by(const WorkingPose& pose, const Eigen::Vector3d& centre, const Eigen::Vector3d& axis,
                      double angle) {
  const auto [sine, cosine] = elementary::sine_cosine(angle);
  Eigen::Matrix3d cross;
  cross << 0.0, -axis.z(), axis.y(), axis.z(), 0.0, -axis.x(), -axis.y(), axis.x(), 0.0;
  RigidTransform turn = RigidTransform::Identity();
  turn.linear() += sine * cross + (1.0 - cosine) * cross * cross;
  turn.translation() = centre - turn.linear() * centre;
  return to_working_pose(from_working_pose(pose) * turn);
}

}  // namespace

RepeatedMotions turned_motions(const Correspondences& correspondences, const BestPoses& poses, double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  const SourceCoordinates coordinates(correspondences, 1);
  const Eigen::Vector3d axis = coordinates.axis(Coordinate::least).cast<double>();
  std::array<Turned, kTurns> turned;
  // The first is the pose itself.
  tbb::parallel_for(std::size_t{1}, kTurns, [&](std::size_t k) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(kTurns);
    const WorkingPose start = turned_by(poses.best().pose, coordinates.viewpoint(), axis, angle);
    const PoseCandidate found = widely_optimise(correspondences, scored(view, start, noise_bound), noise_bound);
    if (found.support.count < 3 || poses.same_motion_as_best(found.pose)) return;
    const std::vector<std::uint32_t> rows = pose_inliers(view, found.pose, noise_bound);
    const auto shared = std::ranges::count_if(rows, [&](std::uint32_t row) { return poses.best_explains(row); });
    if (2 * static_cast<std::size_t>(shared) > rows.size()) return;
    turned[k] = {found, independent_support(view, found.pose, noise_bound)};
  });
  std::ranges::stable_sort(turned, std::ranges::greater{}, &Turned::independent);
  RepeatedMotions result;
  result.looked_at = static_cast<double>(kTurns) * kReached;
  std::vector<SupportedMotion> kept;
  for (const Turned& one : turned) {
    if (one.independent < 3.0 || kept.size() == kMostKept) break;
    if (std::ranges::any_of(kept, [&](const SupportedMotion& m) { return m.is_same(one.found.pose); })) continue;
    kept.emplace_back(view, one.found.pose, noise_bound);
    result.independent.push_back(one.independent);
    if (one.found.support.score > result.best.support.score) result.best = one.found;
  }
  return result;
}

}  // namespace consimd::detail
