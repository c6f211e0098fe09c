#include "noise_bound/bound_attempts.hpp"

#include <algorithm>
#include <numbers>

#include <consimd/solvers/significance.hpp>

#include "search/consensus_search.hpp"
#include "support/independent_rows.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {
namespace {

constexpr Effort kOnAll{.seeds = kSeeds, .bounds_past = 2};
constexpr Effort kOnFew{.seeds = kSeeds, .bounds_past = 2, .glances = 1};
constexpr Effort kOnIndependent{.seeds = kSeeds, .bounds_past = kBounds, .independent = true};
// As much as a registration that finds nothing at first.
constexpr Effort kLast{
    .seeds = ConsensusSearchOptions{}.max_seeds, .bounds_past = 1, .stops_in_doubt = true, .careful = true};
constexpr Effort kLastOfFew{.seeds = kLast.seeds, .bounds_past = kBounds, .glances = 1, .careful = true};

}  // namespace

double glance(const Correspondences& correspondences, const Attempt& attempt) {
  return significance(correspondences, attempt.pose, attempt.bound, Scrutiny::glance).log10_false_poses + penalty();
}

CloseLooks::CloseLooks(const Correspondences& correspondences)
    : correspondences_(correspondences), kept_(std::make_shared<const KeptStructure>(correspondences)) {}

double CloseLooks::log10_false_poses(const WorkingPose& pose, double bound, double enough) {
  auto found = std::ranges::find(backgrounds_, bound, &std::pair<double, Background>::first);
  if (found == backgrounds_.end()) {
    backgrounds_.emplace_back(bound, Background(correspondences_, bound, kept_));
    found = backgrounds_.end() - 1;
  }
  return found->second.log_false_poses(pose, enough * std::numbers::ln10) / std::numbers::ln10;
}

bool CloseLooks::is_significant(const WorkingPose& pose, double bound) {
  const double needed = kSignificantRival - penalty();
  return glance(correspondences_, {bound, pose}) < kBeyondDoubt || log10_false_poses(pose, bound, needed) < needed;
}

std::vector<Effort> efforts(std::size_t rows) {
  if (rows <= kFewRows) return {kOnFew, kLastOfFew};
  return {kOnAll, kOnIndependent, kLast};
}

// From the largest bound on, each half of the last; from the smallest on where the time of a careful search
// matters, which grows with the bound.
void BoundAttempts::run(double largest_bound) {
  double least = kSignificant;
  std::uint32_t since_least = 0;
  bool looked = false;
  const bool upwards = effort_.careful && effort_.stops_in_doubt;
  for (std::uint32_t b = 0; b < kBounds && !stop_.met(); ++b) {
    const double bound = std::ldexp(largest_bound, -static_cast<int>(upwards ? kBounds - 1 - b : b));
    double least_here = 0.0;
    if (effort_.independent) {
      const std::vector<std::uint32_t> rows = rows_for_another_search(correspondences_.view(), bound);
      if (!rows.empty()) least_here = try_bound(correspondences_.subset(rows), bound);
    } else {
      least_here = try_bound(correspondences_, bound);
      if (known_.empty() && !upwards) break;
    }
    if (least_here < least) {
      least = least_here;
      since_least = 0;
      looked = false;
    } else if (least < kSignificant && ++since_least == effort_.bounds_past) {
      glance_at_best();
      looked = true;
      if (beyond_doubt_ || effort_.stops_in_doubt) return;
    }
  }
  if (!looked) glance_at_best();
}

// Searches with the poses of the last bound at hand; log10 of the least number of false poses found.
double BoundAttempts::try_bound(const Correspondences& searched, double bound) {
  ConsensusSearch search(
      searched, {.noise_bound = bound, .seed = seed_, .max_seeds = effort_.seeds, .stop = stop_, .settles = false});
  for (const WorkingPose& pose : known_) search.offer(pose);
  search.run(effort_.careful);
  known_.clear();
  double least = 0.0;
  for (const PoseCandidate* found : {&search.poses().best(), &search.poses().runner_up()}) {
    if (found->support.count < 3) continue;
    known_.push_back(found->pose);
    const double plain = significance(correspondences_, found->pose, bound, Scrutiny::plain).log10_false_poses;
    tried_.push_back({bound, found->pose, plain});
    least = std::min(least, plain);
  }
  return least;
}

void BoundAttempts::glance_at_best() {
  std::vector<Attempt> best = tried_;
  std::ranges::stable_sort(best, {}, rank);
  best.resize(std::min(best.size(), effort_.glances));
  for (Attempt& attempt : best) {
    if (attempt.log10_false_poses >= kSignificant) return;
    attempt.log10_false_poses = glance(correspondences_, attempt);
    if (attempt.log10_false_poses >= kBeyondDoubt) continue;
    beyond_doubt_ = attempt;
    return;
  }
}

}  // namespace consimd::detail
