#include "verdict/another_scale.hpp"

#include <algorithm>
#include <cmath>

#include <consimd/solvers/pose_refinement.hpp>

#include "support/pose_candidate.hpp"
#include "verdict/ambiguity.hpp"

namespace consimd::detail {
namespace {

constexpr std::uint32_t kMostRounds = 20;
// A change of scale that moves points by less than this share of the noise.
constexpr double kStill = 1e-3;

// Calibrations differ by less, and a given noise bound may mean to cover that. One that the data have told may not: it
// is as large as the scale makes it.
constexpr double kCalibration = 0.02;
constexpr double kLeastDifference = 1e-3;
// By so many deviations, and where it explains so much of their squared residuals, the supporters are the rows near a
// centre that the pose turns and grows about, and tell nothing of the rest.
constexpr double kScaleDeviations = 5.0;
constexpr double kMostOfThem = 0.5;
// Where the bound is told by the residuals: without the scale it would be half as large. Of five supporters at the same
// scale one in eight hundred is so, by the F distribution of 1 and 8 degrees of freedom.
constexpr double kHalvesTheBound = 0.75;
// Five rows each of which may be none are expected to be a little fewer than five supporters.
constexpr double kLeastSupporters = 4.5;
// Deviations from which on it is asked how many rows support the pose with a scale of its own: a right pose is by
// chance once in twenty times. One parameter more brings in a row or two.
constexpr double kWorthALook = 2.0;
constexpr std::size_t kByOneParameter = 2;
// The share of the noise bound by which another scale moves the outermost supporters at least: about its centre rows
// support the pose until it moves them by all of the bound.
constexpr double kAtTheRim = 0.5;

// Deviations by which a scale differs from 1. Another scale is itself an error that the supporters share: they are
// those of independent errors.
double scale_deviations(double scale, double deviation, double shared_errors) {
  return std::abs(scale - 1.0) * std::sqrt(shared_errors) / deviation;
}

// The share that the scale explains of the squared residuals of so many supporters. Their variance is that of 3 n - 8
// of them.
double explained_share(double deviations, double supporters) {
  return deviations * deviations / std::max(3.0 * supporters - 8.0, 1.0);
}

// Distance of the outermost supporter from the centre of all, caller's unit.
double reach(const CorrespondenceView& view, const FinalPose& final) {
  double largest = 0.0;
  for (const std::uint32_t row : final.inliers) {
    const Eigen::Vector3d point(view.source(0)[row], view.source(1)[row], view.source(2)[row]);
    largest = std::max(largest, (point - Eigen::Vector3d(final.centre)).squaredNorm());
  }
  return std::sqrt(largest) / view.scale();
}

// Makes the scale grow about the centre of the supporters, which stays where it is.
void rescale(const Correspondences& correspondences, double factor,
             const Eigen::Matrix<double, 3, 1, Eigen::DontAlign>& working_centre, Similarity& similarity) {
  const Eigen::Vector3d centre = Eigen::Vector3d(working_centre) / correspondences.scale() +
                                 Eigen::Map<const Eigen::Vector3d>(correspondences.source_centroid().data());
  RigidTransform& pose = similarity.T_target_source;
  pose.translation() -= (factor - 1.0) * (pose.linear() * centre);
  similarity.scale *= factor;
}

}  // namespace

std::uint32_t refine_similarity(const Correspondences& correspondences, double noise_bound, Similarity& similarity) {
  for (std::uint32_t round = 1; round <= kMostRounds; ++round) {
    const Correspondences scaled = correspondences.with_scaled_source(similarity.scale);
    const RefinedPose refined =
        refine_pose(scaled, to_working_pose(to_working_frame(similarity.T_target_source, scaled)), {noise_bound});
    if (!refined.fit.determined() || !(refined.scale > 0.0)) return round;
    similarity.T_target_source = to_caller_frame(refined.fit.pose, scaled);
    rescale(scaled, refined.scale, refined.centre, similarity);
    // A working frame is about 1 in size.
    if (std::abs(refined.scale - 1.0) < kStill * refined.sigma * scaled.scale()) return round;
  }
  return kMostRounds;
}

bool is_at_another_scale(const Correspondences& correspondences, const PoseTest& test, const FinalPose& final) {
  if (!(final.scale_deviation > 0.0) || !(final.scale > 0.0)) return false;
  const double deviations = scale_deviations(final.scale, final.scale_deviation, final.shared_errors);
  if (deviations < kWorthALook) return false;
  if (std::abs(final.scale - 1.0) >= kCalibration && deviations > kScaleDeviations &&
      explained_share(deviations, static_cast<double>(final.inliers.size())) > kMostOfThem) {
    return true;
  }
  if (std::abs(final.scale - 1.0) * reach(correspondences.view(), final) < kAtTheRim * test.noise_bound) return false;
  Similarity similarity{1.0, to_caller_frame(final.pose, correspondences)};
  rescale(correspondences, final.scale, final.centre, similarity);
  refine_similarity(correspondences, test.noise_bound, similarity);
  const Correspondences scaled = correspondences.with_scaled_source(similarity.scale);
  const WorkingPose pose = to_working_pose(to_working_frame(similarity.T_target_source, scaled));
  const std::size_t supporters = pose_inliers(scaled.view(), pose, test.noise_bound).size();
  return supporters > final.inliers.size() + kByOneParameter && !is_rival(final.inliers.size(), supporters);
}

bool hides_another_scale(const Correspondences& correspondences, const RigidTransform& T_target_source,
                         double noise_bound) {
  const RefinedPose refined =
      refine_pose(correspondences, to_working_pose(to_working_frame(T_target_source, correspondences)), {noise_bound});
  if (!(refined.scale_deviation > 0.0) || std::abs(refined.scale - 1.0) < kLeastDifference) return false;
  const double deviations = scale_deviations(refined.scale, refined.scale_deviation, refined.shared_errors);
  return refined.inliers >= kLeastSupporters && explained_share(deviations, refined.inliers) > kHalvesTheBound;
}

}  // namespace consimd::detail
