#include "scale/rival_scale.hpp"

#include <cmath>
#include <vector>

#include <consimd/solvers/scale_voting.hpp>

#include "call/refusal.hpp"
#include "search/consensus_search.hpp"
#include "verdict/ambiguity.hpp"
#include "verdict/pairing_chances.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {
namespace {

// Evidence of up to so many rows is thin: from more supporters their own scale stands out (see is_at_another_scale).
// Among many rows, for which it takes a millisecond or two, only where log10 of false poses is no less than five times
// what success needs.
constexpr std::size_t kFewSupporters = 24;
constexpr double kThin = 5.0 * kSignificant;
// Scales closer than this are those of calibrations.
constexpr double kLeastDifference = 0.01;
// A sample that tells a scale which a quarter of the rows agree on.
constexpr std::uint32_t kVoters = 64;
constexpr std::uint32_t kPartners = 512;

std::uint32_t support_at(double scale, const Correspondences& correspondences, const Registration& result) {
  const Correspondences scaled = correspondences.with_scaled_source(scale);
  ConsensusSearch search(scaled, {.noise_bound = result.noise_bound, .seed = result.seed, .max_seeds = kVoters});
  search.run(false);
  return search.best().support.count;
}

}  // namespace

void refuse_at_rival_scale(const Correspondences& correspondences, Registration& result) {
  // A scale that was estimated has had its rivals.
  if (!result.has_pose() || result.scale != 1.0 || result.inliers.size() > kFewSupporters) return;
  if (correspondences.size() > kFewCorrespondences && result.log10_false_poses < kThin) return;
  const std::vector<VotedScale> voted = scale_voting(correspondences, {.noise_bound = result.noise_bound,
                                                                       .seed = result.seed,
                                                                       .max_voters = kVoters,
                                                                       .max_partners = kPartners,
                                                                       .max_scales = 1});
  if (voted.empty() || std::abs(voted.front().scale - 1.0) < kLeastDifference) return;
  if (!is_rival(result.inliers.size(), support_at(voted.front().scale, correspondences, result))) refuse(result);
}

}  // namespace consimd::detail
