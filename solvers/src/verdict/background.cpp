#include "verdict/background.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <consimd/kernels/elementary_functions.hpp>

#include "support/repeated_points.hpp"
#include "verdict/false_poses.hpp"
#include "verdict/kept_agreement.hpp"
#include "verdict/kept_structure.hpp"
#include "verdict/pairing_chances.hpp"
#include "verdict/reached_targets.hpp"

namespace consimd::detail {
namespace {

// Mismatched pairings of all correspondences, and pairs whose lengths are compared.
constexpr std::uint32_t kShifts = 32;
constexpr std::uint32_t kPairs = 4096;
constexpr std::uint32_t kStratumPairs = 1024;
// Pairing that gives so many hits by chance alone, once in so many times, shows no structure: one in fifty for all
// eighteen ways of pairing together. Where random pairing gives next to no hits, structure gives few as well and cannot
// be that unlikely; once in twenty is enough there, with which 3 instead of 6 of 180 problems of kept range end as a
// success. Of eighteen ways one is as unlikely as that for nothing, so that it must show at twice the bound as well,
// where hits are up to eight times as many: 2 hits for 0.25 had a true pose of 10^-5.3 be worth 10^-1.0.
constexpr double kNoStructure = 1e-3;
constexpr double kNoStructureOfFew = 0.05;
constexpr double kFewHits = 8.0;
constexpr double kWider = 2.0;
// Where random pairing gives fewer, no hit at all is no sign that structure gives none.
constexpr double kNextToNone = 1.0;
// Half of the noise bound is at this position among the tested ones.
constexpr std::size_t kHalf = 2;
static_assert(kTestedBounds[kHalf] == 0.5);
// Targets that a moved source reaches, up to which they are found in cells rather than among each stratum's rows: of
// uniform rows, 1000 and 5000, both take as long at three to five.
constexpr double kLittle = 4.0;

bool same(const WorkingPose& a, const WorkingPose& b) {
  return std::ranges::equal(a.rotation, b.rotation) && std::ranges::equal(a.translation, b.translation);
}

// Whether random pairing gives so many hits no more than once in as many times as `chance` tells.
bool is_rarer(double at_random, double hits, double trials, double chance) {
  return log_binomial_tail(trials, hits, at_random) <= elementary::log(chance);
}

// The chance that hits among trials tell of, or that of random pairing where they do not differ from it. `shows_wider`
// tells whether they do at a wider bound.
template <typename ShowsWider>
double structured(double at_random, double hits, double trials, const ShowsWider& shows_wider) {
  const bool is_structure =
      is_rarer(at_random, hits, trials, kNoStructure) ||
      (at_random * trials < kFewHits && is_rarer(at_random, hits, trials, kNoStructureOfFew) && shows_wider());
  return is_structure ? std::max(at_random, chance(hits, trials)) : at_random;
}

// Where structure shows at the bound itself, it is there at narrower ones as well, whose hits may be too few to show
// it: their chances are told from how hits grow towards the bound, as in the three dimensions of space at most.
void narrow_down(const PairingHits& support, const Chances& at_random, Chances& chances) {
  if (!is_rarer(at_random.support.front(), support.hits.front(), support.trials, kNoStructure)) return;
  const double growth = elementary::log((support.hits.front() + 1.0) / (support.hits[kHalf] + 1.0));
  const double dimension = std::clamp(-growth / elementary::log(kTestedBounds[kHalf]), 1.0, 3.0);
  for (std::size_t b = 1; b < kTestedBounds.size(); ++b) {
    if (at_random.support[b] * support.trials >= kNextToNone) continue;
    const double share = elementary::exp(dimension * elementary::log(kTestedBounds[b]));
    chances.support[b] = std::max(chances.support[b], share * chances.support.front());
  }
}

}  // namespace

Background::Background(const Correspondences& correspondences, double noise_bound,
                       std::shared_ptr<const KeptStructure> kept)
    : correspondences_(&correspondences),
      noise_bound_(noise_bound),
      coherence_(correspondences.view(), noise_bound),
      kept_(kept ? std::move(kept) : std::make_shared<const KeptStructure>(correspondences)),
      kinds_(kept_->kinds()) {}

const Background::Alike& Background::lookalikes() const {
  if (!lookalikes_) {
    Lookalikes lookalikes(correspondences_->view(), noise_bound_, kNearMisses * noise_bound_);
    const PairingHits lengths = lookalikes.lengths(noise_bound_, kStratumPairs);
    lookalikes_ = Alike{std::move(lookalikes), lengths};
  }
  return *lookalikes_;
}

const std::vector<Background::Kept>& Background::kind(std::size_t k) const {
  std::vector<Kept>& result = kinds_[k];
  if (result.empty()) {
    for (Strata& strata : kept_->strata(k, kNearMisses * noise_bound_)) {
      const PairingHits lengths = strata.lengths(noise_bound_, kStratumPairs);
      result.push_back({std::move(strata), lengths});
    }
  }
  return result;
}

double Background::log_false_poses(const WorkingPose& pose, double enough) const {
  const auto told = std::ranges::find_if(told_, [&](const Told& former) { return same(former.pose, pose); });
  if (told != told_.end() && (told->is_all || told->log_false_poses >= enough)) return told->log_false_poses;
  const double measured = this->measured(pose, enough);
  const Told news{pose, measured, measured < enough};
  if (told != told_.end()) {
    *told = news;
  } else {
    told_.push_back(news);
  }
  return measured;
}

double Background::measured(const WorkingPose& pose, double enough) const {
  const CorrespondenceView view = correspondences_->view();
  const auto size = static_cast<double>(view.size());
  const double radius = coherence_.length(pose, kLeastRadius, kLargestRadius) * noise_bound_;
  const Supports found = supports(view, pose, noise_bound_, radius);
  const MatchedPoints matched(view, pose, noise_bound_);
  const double reach = noise_bound_ * fit_gain(found);
  const Chances at_random =
      random_chances(view, pose, noise_bound_, reach, kPairs, kShifts, RareHits::extrapolated, matched);
  double most = detail::log_false_poses(size, found, at_random);
  double at_random_wider = -1.0;
  const auto look = [&](const PairingHits& support, const PairingHits& lengths, const auto& pairing) {
    std::optional<bool> told;
    const auto shows_wider = [&] {
      if (told) return *told;
      const std::array wider{kWider * reach};
      if (at_random_wider < 0.0) {
        at_random_wider = pose_chances(view, pose, wider, kShifts, RareHits::extrapolated, matched).front();
      }
      const PairingHits hits = pairing.support(pose, wider.front(), matched);
      told = is_rarer(at_random_wider, hits.hits.front(), hits.trials, kNoStructureOfFew);
      return *told;
    };
    // A thousand pairs of lengths have hits enough by chance.
    const auto is_told_by_lengths = [] { return true; };
    Chances chances;
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      chances.support[b] = structured(at_random.support[b], support.hits[b], support.trials, shows_wider);
      chances.length[b] = structured(at_random.length[b], lengths.hits[b], lengths.trials, is_told_by_lengths);
    }
    narrow_down(support, at_random, chances);
    most = std::max(most, detail::log_false_poses(size, found, chances));
  };
  if (most >= enough) return most;
  // Two lines determine a pose, whatever rows they have.
  for (const auto& [chances, along] : kept_chances(*correspondences_, pose, noise_bound_, reach, at_random, matched)) {
    const bool is_told = along.empty() || supports(view, pose, noise_bound_, radius, along).front().spread > 2.0;
    most = std::max(most, is_told ? detail::log_false_poses(size, found, chances) : 0.0);
  }
  if (most >= enough) return most;
  if (are_on_two_coherent_lines(view, pose, noise_bound_, radius)) most = std::max(most, 0.0);
  if (most >= enough) return most;
  const auto& [alike, alike_lengths] = lookalikes();
  look(alike.support(pose, reach, matched), alike_lengths, alike);
  if (most >= enough) return most;
  const bool reaches_little = at_random.support.front() * size < kLittle;
  const std::vector<ReachedTarget> reached =
      reaches_little ? reached_targets(view, pose, reach) : std::vector<ReachedTarget>{};
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    for (const auto& [strata, lengths] : kind(k)) {
      look(reaches_little ? strata.support(reached, reach, matched) : strata.support(pose, reach, matched), lengths,
           strata);
      if (most >= enough) return most;
    }
  }
  return most;
}

}  // namespace consimd::detail
