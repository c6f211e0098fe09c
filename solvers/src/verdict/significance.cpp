#include <consimd/solvers/significance.hpp>

#include <algorithm>
#include <numbers>

#include "call/option_checks.hpp"
#include "support/repeated_points.hpp"
#include "verdict/background.hpp"
#include "verdict/coherence.hpp"
#include "verdict/false_poses.hpp"
#include "verdict/kept_structure.hpp"
#include "verdict/pairing_chances.hpp"
#include "verdict/pose_test.hpp"
#include "verdict/supporters.hpp"

namespace consimd {
namespace {

// A glance takes so many mismatched pairings of all correspondences, and compares the lengths of so many pairs.
constexpr std::uint32_t kGlanceShifts = 8;
constexpr std::uint32_t kGlancePairs = 256;
// Pairs where structure is not looked at.
constexpr std::uint32_t kPlainPairs = 1024;
// A glance takes structure to give a pose at most so many times the support that random pairing does, and lengths that
// agree so many times as often.
constexpr double kStrongestStructure = 100.0;
constexpr double kStrongestLikeness = 2.0;
// What a sample tells of structure, times this, is more than what all rows do.
constexpr double kSafety = 4.0;
// ln of false poses from which on a first glance is enough.
constexpr double kEnough = detail::kBeyondDoubt * std::numbers::ln10;

// Bounds are compared by it, and what a fit gains is about the same at all of them.
double plain_look(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound) {
  const detail::MatchedPoints matched(view, pose, noise_bound);
  const detail::Supports found = detail::supports(view, pose, noise_bound, detail::kLeastRadius * noise_bound);
  const detail::Chances chances = detail::random_chances(view, pose, noise_bound, noise_bound, kPlainPairs,
                                                         kGlanceShifts, detail::RareHits::extrapolated, matched);
  return detail::log_false_poses(static_cast<double>(view.size()), found, chances);
}

double glance(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound) {
  const detail::MatchedPoints matched(view, pose, noise_bound);
  const detail::Supports found = detail::supports(view, pose, noise_bound, detail::kLargestRadius * noise_bound);
  const double reach = noise_bound * detail::fit_gain(found);
  detail::Chances chances = detail::random_chances(view, pose, noise_bound, reach, kGlancePairs, kGlanceShifts,
                                                   detail::RareHits::laplace, matched);
  for (double& chance : chances.support) chance = std::min(1.0, kStrongestStructure * chance);
  for (double& chance : chances.length) chance = std::min(1.0, kStrongestLikeness * chance);
  return detail::log_false_poses(static_cast<double>(view.size()), found, chances);
}

// A second glance, at structure in a sample of the rows.
double second_glance(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  const auto size = static_cast<double>(view.size());
  const detail::Supports found = detail::supports(view, pose, noise_bound, detail::kLargestRadius * noise_bound);
  const double reach = noise_bound * detail::fit_gain(found);
  const detail::MatchedPoints matched(view, pose, noise_bound);
  detail::Chances chances = detail::random_chances(view, pose, noise_bound, reach, kGlancePairs, kGlanceShifts,
                                                   detail::RareHits::laplace, matched);
  for (double& chance : chances.length) chance = std::min(1.0, kStrongestLikeness * chance);
  for (const detail::Strata& strata :
       detail::KeptStructure::sampled(correspondences, detail::kNearMisses * noise_bound)) {
    const detail::PairingHits kept = strata.support(pose, reach, matched);
    for (std::size_t b = 0; b < detail::kTestedBounds.size(); ++b) {
      chances.support[b] = std::max(chances.support[b], kSafety * detail::chance(kept.hits[b], kept.trials));
    }
  }
  for (double& chance : chances.support) chance = std::min(1.0, chance);
  return detail::log_false_poses(size, found, chances);
}

}  // namespace

Significance significance(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound,
                          Scrutiny scrutiny) {
  detail::require_length("noise_bound", noise_bound);
  if (!correspondences.far_rows().empty()) {
    return significance(correspondences.subset(correspondences.near_rows()), pose, noise_bound, scrutiny);
  }
  const CorrespondenceView view = correspondences.view();
  if (view.size() < 3) return {};
  if (scrutiny == Scrutiny::plain) return {plain_look(view, pose, noise_bound) / std::numbers::ln10};
  if (scrutiny == Scrutiny::close) {
    return {detail::Background(correspondences, noise_bound).log_false_poses(pose) / std::numbers::ln10};
  }
  double false_poses = glance(view, pose, noise_bound);
  if (false_poses > kEnough) false_poses = std::min(false_poses, second_glance(correspondences, pose, noise_bound));
  const bool is_in_doubt = false_poses < 0.0 && detail::are_on_two_coherent_lines(view, pose, noise_bound,
                                                                                  detail::kLargestRadius * noise_bound);
  return {is_in_doubt ? 0.0 : false_poses / std::numbers::ln10};
}

}  // namespace consimd
