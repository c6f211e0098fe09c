#include <consimd/solvers/scale_voting.hpp>

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>

#include <consimd/kernels/length_ratio.hpp>
#include <consimd/solvers/adaptive_voting.hpp>

#include "call/option_checks.hpp"
#include "sampling/counter_random.hpp"

namespace consimd {
namespace {

// Bins of a scale by the leading bits of its single-precision number: 64 an octave, 0.8 to 1.6 % wide.
constexpr int kOctaves = 10;  // to either side of 1
constexpr std::uint32_t kMantissaBits = 6;
constexpr std::uint32_t kShift = 23 - kMantissaBits;
constexpr std::uint32_t kFirstBin = (127U - kOctaves) << kMantissaBits;
constexpr std::size_t kBins = std::size_t{2 * kOctaves} << kMantissaBits;

// Pairings of a voter's lengths that tell what chance gives.
constexpr std::size_t kPairings = 2;
constexpr float kStandsOut = 2.0F;  // in standard deviations
// An interval with ends further apart than this factor tells nothing.
constexpr float kWidest = 4.0F;
// The exact vote takes at most this many.
constexpr std::size_t kExactVoters = 32;
constexpr std::size_t kExactPartners = 2048;
// A peak reaches down to this share of its height.
constexpr double kPeakShare = 0.5;

std::size_t bin_of(float scale) {
  const std::size_t bin = std::bit_cast<std::uint32_t>(scale) >> kShift;
  return std::clamp<std::size_t>(bin, kFirstBin, kFirstBin + kBins - 1) - kFirstBin;
}

float scale_of(std::size_t bin) {
  return std::bit_cast<float>((static_cast<std::uint32_t>(bin) + kFirstBin) << kShift);
}

bool tells(float low, float high) { return low > 0.0F && high < kWidest * low; }

/// Partners of the voters with the voters behind them, as they are and paired at random.
class Pairings {
 public:
  Pairings(const Correspondences& correspondences, const ScaleVotingOptions& options)
      : partners_(std::min<std::size_t>(correspondences.size(), options.max_partners)),
        voters_(std::min<std::size_t>(correspondences.size(), options.max_voters)) {
    std::vector<std::uint32_t> order(correspondences.size());
    std::iota(order.begin(), order.end(), 0U);
    CounterRandom random(options.seed, detail::RandomStage::scale_voters, 0);
    for (std::size_t i = 0; i < std::max(partners_, voters_); ++i) {
      std::swap(order[i], order[i + random.below(static_cast<std::uint32_t>(order.size() - i))]);
    }
    std::vector<std::uint32_t> sources(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(partners_));
    sources.insert(sources.end(), order.begin(), order.begin() + static_cast<std::ptrdiff_t>(voters_));
    for (std::size_t p = 0; p <= kPairings; ++p) {
      std::vector<std::uint32_t> targets = sources;
      const std::size_t turn = p == 0 ? 0 : std::max<std::size_t>(p * partners_ / (kPairings + 1), 1);
      std::rotate(targets.begin(), targets.begin() + static_cast<std::ptrdiff_t>(turn % partners_),
                  targets.begin() + static_cast<std::ptrdiff_t>(partners_));
      pairings_[p].assign_pairs(correspondences, sources, targets);
    }
  }

  [[nodiscard]] std::size_t partners() const noexcept { return partners_; }
  [[nodiscard]] std::size_t voters() const noexcept { return voters_; }
  /// 0: as they are.
  [[nodiscard]] const Correspondences& operator[](std::size_t pairing) const { return pairings_[pairing]; }

 private:
  using CounterRandom = detail::CounterRandom;

  std::size_t partners_;
  std::size_t voters_;
  std::array<Correspondences, kPairings + 1> pairings_;
};

/// The intervals of one voter.
struct Intervals {
  std::vector<float> lows;
  std::vector<float> highs;

  void measure(const Correspondences& pairing, std::size_t row, double bound) {
    lows.resize(pairing.view().padded_size());
    highs.resize(pairing.view().padded_size());
    scale_intervals(pairing, static_cast<std::uint32_t>(row), bound, lows, highs);
  }
};

using Counts = std::array<std::int32_t, kBins + 1>;

/// Adds how many of the first `size` intervals hold each bin.
void add_coverage(const Intervals& intervals, std::size_t size, Counts& counts) {
  Counts steps{};
  for (std::size_t j = 0; j < size; ++j) {
    if (!tells(intervals.lows[j], intervals.highs[j])) continue;
    ++steps[bin_of(intervals.lows[j])];
    --steps[bin_of(intervals.highs[j]) + 1];
  }
  std::int32_t open = 0;
  for (std::size_t b = 0; b < kBins; ++b) {
    open += steps[b];
    counts[b] += open;
  }
}

/// What the pairs of each voter exceed chance by, V x kBins, in standard deviations.
std::vector<float> excess_of_voters(const Pairings& pairings, double bound) {
  std::vector<float> excess(pairings.voters() * kBins);
  tbb::enumerable_thread_specific<Intervals> scratch;
  tbb::parallel_for(std::size_t{0}, pairings.voters(), [&](std::size_t v) {
    Intervals& intervals = scratch.local();
    Counts seen{};
    Counts chance{};
    for (std::size_t p = 0; p <= kPairings; ++p) {
      intervals.measure(pairings[p], pairings.partners() + v, bound);
      add_coverage(intervals, pairings.partners(), p == 0 ? seen : chance);
    }
    for (std::size_t b = 0; b < kBins; ++b) {
      const float expected = static_cast<float>(chance[b]) / kPairings;
      excess[v * kBins + b] = (static_cast<float>(seen[b]) - expected) / std::sqrt(expected + 1.0F);
    }
  });
  return excess;
}

std::vector<double> votes_of(std::span<const float> excess) {
  std::vector<double> votes(kBins, 0.0);
  for (std::size_t k = 0; k < excess.size(); ++k) {
    const double above = static_cast<double>(excess[k]) - static_cast<double>(kStandsOut);
    if (above > 0.0) votes[k % kBins] += above * above;
  }
  return votes;
}

/// The bins [first, last] of the highest peak left.
struct Peak {
  std::size_t first, top, last;
};

Peak highest_peak(std::span<const double> votes) {
  const auto top = static_cast<std::size_t>(std::ranges::max_element(votes) - votes.begin());
  Peak peak{top, top, top};
  while (peak.first > 0 && votes[peak.first - 1] > kPeakShare * votes[top]) --peak.first;
  while (peak.last + 1 < kBins && votes[peak.last + 1] > kPeakShare * votes[top]) ++peak.last;
  return peak;
}

VotedScale measure_scale(const Pairings& pairings, std::span<const float> excess, const Peak& peak, double votes,
                         double bound) {
  VotedScale result{.scale = std::sqrt(static_cast<double>(scale_of(peak.top)) * scale_of(peak.top + 1)),
                    .votes = votes};
  const auto excess_at_top = [&](std::uint32_t voter) { return excess[voter * kBins + peak.top]; };
  std::vector<std::uint32_t> voters;
  for (std::uint32_t v = 0; v < pairings.voters(); ++v) {
    if (excess_at_top(v) > kStandsOut) voters.push_back(v);
  }
  result.voters = voters.size();
  std::ranges::stable_sort(voters, std::ranges::greater{}, excess_at_top);
  voters.resize(std::min(voters.size(), kExactVoters));
  std::vector<double> values;
  std::vector<double> bounds;
  Intervals intervals;
  const std::size_t partners = std::min(pairings.partners(), kExactPartners);
  for (const std::uint32_t v : voters) {
    intervals.measure(pairings[0], pairings.partners() + v, bound);
    for (std::size_t j = 0; j < partners; ++j) {
      const float low = intervals.lows[j];
      const float high = intervals.highs[j];
      if (!tells(low, high) || high < scale_of(peak.first) || low > scale_of(peak.last + 1)) continue;
      values.push_back(0.5 * (static_cast<double>(low) + static_cast<double>(high)));
      bounds.push_back(std::max(0.5 * (static_cast<double>(high) - static_cast<double>(low)), 1e-7 * values.back()));
    }
  }
  result.measurements = values.size();
  const AdaptiveVote vote = adaptive_voting(values, bounds);
  if (!vote.consensus.empty()) result.scale = vote.value;
  return result;
}

}  // namespace

std::vector<VotedScale> scale_voting(const Correspondences& correspondences, const ScaleVotingOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  detail::require_length("tolerance", options.tolerance);
  detail::require_above_zero("max_voters", options.max_voters);
  detail::require_above_zero("max_partners", options.max_partners);
  detail::require_above_zero("max_scales", options.max_scales);
  if (!correspondences.far_rows().empty()) {
    return scale_voting(correspondences.subset(correspondences.near_rows()), options);
  }
  std::vector<VotedScale> scales;
  if (correspondences.size() < 3) return scales;
  const double bound = std::min(options.tolerance * options.noise_bound, 1e300);
  const Pairings pairings(correspondences, options);
  const std::vector<float> excess = excess_of_voters(pairings, bound);
  std::vector<double> votes = votes_of(excess);
  while (scales.size() < options.max_scales) {
    const Peak peak = highest_peak(votes);
    if (votes[peak.top] == 0.0) break;
    scales.push_back(measure_scale(pairings, excess, peak, votes[peak.top], bound));
    // Its flanks are no other peak.
    const std::size_t reach = peak.last - peak.first + 4;
    const std::size_t begin = peak.first > reach ? peak.first - reach : 0;
    std::fill(votes.begin() + static_cast<std::ptrdiff_t>(begin),
              votes.begin() + static_cast<std::ptrdiff_t>(std::min(peak.last + reach + 1, kBins)), 0.0);
  }
  return scales;
}

}  // namespace consimd
