#include "ransac/three_point_search.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/three_point_fit.hpp>
#include <consimd/kernels/working_length.hpp>

#include "sampling/sampling.hpp"
#include "support/points.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/pose_checks.hpp"

namespace consimd::detail {
namespace {

// Rounds of samples grow from the first to the last size: few for easy problems, enough to keep many threads busy in
// hard ones.
constexpr std::uint64_t kFirstRound = 16;
constexpr std::uint64_t kLargestRound = 16'384;
constexpr std::size_t kDrawsPerTask = 1024;
constexpr std::size_t kFitsPerTask = 16;
// A sample's pose is looked at closely if it has this share of the best pose's score: samples are noisy, and rivals
// count down to four fifths.
constexpr float kWorthOptimising = 0.4F;
// One row in so many tells first whether a pose may have that share, up to this many deviations of the number expected.
constexpr std::size_t kPreviewed = 6;
constexpr std::size_t kLeastPreview = 2 * kBlock;
constexpr double kDeviations = 1.0;

// Whether lengths of squares `a` and `b` differ by less than the tolerance (see length_consistency.hpp).
bool lengths_agree(float a, float b, float squared_tolerance) {
  return (a - b) * (a - b) < squared_tolerance * std::max(2.0F * (a + b) - squared_tolerance, squared_tolerance);
}

}  // namespace

ThreePointSearch::ThreePointSearch(const Correspondences& correspondences, const RansacOptions& options)
    : correspondences_(correspondences),
      options_(options),
      poses_(correspondences, options.noise_bound),
      wanted_(options.max_iterations) {
  const auto tolerance =
      static_cast<float>(working_length(correspondences, options.length_tolerance * options.noise_bound));
  squared_tolerance_ = tolerance * tolerance;
  std::vector<std::uint32_t> rows(correspondences.size() / kPreviewed);
  if (rows.size() < kLeastPreview) return;
  CounterRandom random(options.seed, RandomStage::permutation, 0);
  for (std::uint32_t& row : rows) row = random.below(static_cast<std::uint32_t>(correspondences.size()));
  preview_ = correspondences.subset(rows);
}

std::uint64_t ThreePointSearch::iterations_needed() const {
  const std::uint32_t support = poses_.best().support.count;
  if (!options_.confidence || support < 3) return options_.max_iterations;
  return detail::iterations_needed(*options_.confidence, support / static_cast<double>(correspondences_.size()), 3);
}

void ThreePointSearch::run() {
  for (std::uint64_t round = kFirstRound; iterations_ < wanted_; round = std::min(2 * round, kLargestRound)) {
    if (options_.stop.met()) {
      stopped_ = true;
      return;
    }
    const std::uint64_t end = std::min(iterations_ + round, wanted_);
    draw(end - iterations_);
    fit();
    for (std::size_t s = 0; s < samples_.size() && sample_iterations_[s] < wanted_; ++s) offer(s);
    iterations_ = std::min(end, wanted_);
  }
}

void ThreePointSearch::draw(std::uint64_t count) {
  const auto size = static_cast<std::uint32_t>(correspondences_.size());
  drawn_.resize(count);
  worth_.resize(count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kDrawsPerTask), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      CounterRandom random(options_.seed, RandomStage::three_point, iterations_ + i);
      drawn_[i] = draw_triple(random, size);
      worth_[i] = worth_fitting(drawn_[i]) ? 1 : 0;
    }
  });
  samples_.clear();
  sample_iterations_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if (worth_[i] == 0) continue;
    samples_.push_back(drawn_[i]);
    sample_iterations_.push_back(iterations_ + i);
  }
}

bool ThreePointSearch::worth_fitting(const IndexTriple& sample) const {
  const CorrespondenceView view = correspondences_.view();
  const auto agree = [&](std::uint32_t i, std::uint32_t j) {
    return lengths_agree(squared_distance(source_point(view, i), source_point(view, j)),
                         squared_distance(target_point(view, i), target_point(view, j)), squared_tolerance_);
  };
  const auto& [first, second, third] = sample;
  if (!agree(first, second) || !agree(first, third) || !agree(second, third)) return false;
  // Three rows that an optimised pose explains would lead to it again.
  return !options_.local_optimisation || poses_.best().support.count < 3 || !poses_.best_explains(first) ||
         !poses_.best_explains(second) || !poses_.best_explains(third);
}

void ThreePointSearch::fit() {
  fits_.resize(samples_.size());
  support_.resize(samples_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, samples_.size(), kFitsPerTask), [&](const auto& range) {
    const std::size_t first = range.begin();
    const std::span<WorkingPose> fits = std::span(fits_).subspan(first, range.size());
    three_point_fits(correspondences_, std::span(samples_).subspan(first, range.size()), fits);
    score(fits, std::span(support_).subspan(first, range.size()));
  });
}

// Poses that the preview turns down get no support.
void ThreePointSearch::score(std::span<const WorkingPose> poses, std::span<PoseSupport> support) const {
  const double expected = kWorthOptimising * poses_.best().support.score * static_cast<double>(preview_.size()) /
                          static_cast<double>(correspondences_.size());
  const double least = expected - kDeviations * std::sqrt(expected);
  if (least <= 1.0) return alignment_scores(correspondences_, poses, options_.noise_bound, support);
  std::array<std::uint32_t, kFitsPerTask> counts{};
  for (std::size_t begin = 0; begin < poses.size(); begin += kFitsPerTask) {
    const std::size_t size = std::min(poses.size() - begin, kFitsPerTask);
    alignment_counts(preview_, poses.subspan(begin, size), options_.noise_bound, std::span(counts).first(size));
    for (std::size_t i = 0; i < size; ++i) {
      support[begin + i] = {};
      if (counts[i] < least) continue;
      alignment_scores(correspondences_, poses.subspan(begin + i, 1), options_.noise_bound,
                       support.subspan(begin + i, 1));
    }
  }
}

void ThreePointSearch::offer(std::size_t position) {
  PoseCandidate candidate{fits_[position], support_[position]};
  if (candidate.support.score <= kWorthOptimising * poses_.best().support.score) return;
  if (options_.local_optimisation) {
    if (candidate.support.score <= highest_sample_score_ && poses_.same_motion_as_best(candidate.pose)) return;
    highest_sample_score_ = std::max(highest_sample_score_, candidate.support.score);
    candidate = locally_optimise(correspondences_, candidate, options_.noise_bound);
  }
  if (!poses_.offer(candidate)) return;
  best_sample_ = samples_[position];
  wanted_ =
      std::min<std::uint64_t>(std::max(sample_iterations_[position] + 1, iterations_needed()), options_.max_iterations);
}

std::vector<std::uint32_t> ThreePointSearch::best_set() const {
  return rows_agreeing_with(correspondences_, best_sample_, options_.noise_bound);
}

}  // namespace consimd::detail
