#include "verdict/background.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <mutex>
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
// Kinds of structure that several threads look at side by side. One of them that explains the pose ends the look, so
// that what was done for the others is lost then.
constexpr std::size_t kAtOnce = 4;

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

// A pose, what supports it, and what random pairing gives it.
class HeldPose {
 public:
  HeldPose(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double radius)
      : view_(view),
        pose_(pose),
        matched_(view, pose, noise_bound),
        found_(supports(view, pose, noise_bound, radius)),
        reach_(noise_bound * fit_gain(found_)),
        at_random_(random_chances(view, pose, noise_bound, reach_, kPairs, kShifts, RareHits::extrapolated, matched_)),
        reaches_little_(at_random_.support.front() * static_cast<double>(view.size()) < kLittle) {}

  [[nodiscard]] const MatchedPoints& matched() const { return matched_; }
  [[nodiscard]] double reach() const { return reach_; }  // caller's unit
  [[nodiscard]] const Chances& at_random() const { return at_random_; }

  [[nodiscard]] double log_false_poses(const Chances& chances) const {
    return detail::log_false_poses(static_cast<double>(view_.size()), found_, chances);
  }

  // Several threads may ask at a time.
  [[nodiscard]] PairingHits support(const Lookalikes& lookalikes) const {
    return lookalikes.support(pose_, reach_, matched_);
  }
  [[nodiscard]] PairingHits support(const Strata& strata) const {
    if (!reaches_little_) return strata.support(pose_, reach_, matched_);
    // Nothing in it waits for other tasks, one of which may ask for the same.
    std::call_once(is_reached_, [this] { reached_ = reached_targets(view_, pose_, reach_); });
    return strata.support(reached_, reach_, matched_);
  }

  // ln of false poses where pairing of a kind gives the pose as much, beyond what random pairing does.
  template <typename Pairing>
  [[nodiscard]] double log_false_poses(const Pairing& pairing, const PairingHits& support, const PairingHits& lengths) {
    std::optional<bool> told;
    const auto shows_wider = [&] {
      if (!told) told = this->shows_wider(pairing);
      return *told;
    };
    // A thousand pairs of lengths have hits enough by chance.
    const auto is_told_by_lengths = [] { return true; };
    Chances chances;
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      chances.support[b] = structured(at_random_.support[b], support.hits[b], support.trials, shows_wider);
      chances.length[b] = structured(at_random_.length[b], lengths.hits[b], lengths.trials, is_told_by_lengths);
    }
    narrow_down(support, at_random_, chances);
    return log_false_poses(chances);
  }

 private:
  template <typename Pairing>
  bool shows_wider(const Pairing& pairing) {
    const std::array wider{kWider * reach_};
    if (!at_random_wider_) {
      at_random_wider_ = pose_chances(view_, pose_, wider, kShifts, RareHits::extrapolated, matched_).front();
    }
    const PairingHits hits = pairing.support(pose_, wider.front(), matched_);
    return is_rarer(*at_random_wider_, hits.hits.front(), hits.trials, kNoStructureOfFew);
  }

  CorrespondenceView view_;
  const WorkingPose& pose_;
  MatchedPoints matched_;
  Supports found_;
  double reach_;
  Chances at_random_;
  bool reaches_little_;
  std::optional<double> at_random_wider_;
  mutable std::once_flag is_reached_;
  mutable std::vector<ReachedTarget> reached_;
};

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
  const double radius = coherence_.length(pose, kLeastRadius, kLargestRadius) * noise_bound_;
  HeldPose held(view, pose, noise_bound_, radius);
  double most = held.log_false_poses(held.at_random());
  if (most >= enough) return most;
  // Two lines determine a pose, whatever rows they have.
  for (const auto& [chances, along] :
       kept_chances(*correspondences_, pose, noise_bound_, held.reach(), held.at_random(), held.matched())) {
    const bool is_told = along.empty() || supports(view, pose, noise_bound_, radius, along).front().spread > 2.0;
    most = std::max(most, is_told ? held.log_false_poses(chances) : 0.0);
  }
  if (most >= enough) return most;
  if (are_on_two_coherent_lines(view, pose, noise_bound_, radius)) most = std::max(most, 0.0);
  if (most >= enough) return most;
  // Lookalikes come first, then strata of one kind after the other.
  const std::size_t structures = 1 + kinds_.size();
  const auto at_once = std::min(kAtOnce, static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
  std::array<std::vector<PairingHits>, kAtOnce> support;
  for (std::size_t first = 0; first < structures; first += at_once) {
    const std::size_t end = std::min(first + at_once, structures);
    tbb::parallel_for(first, end, [&](std::size_t s) {
      std::vector<PairingHits>& here = support[s - first];
      here.clear();
      if (s == 0) {
        here.push_back(held.support(lookalikes().lookalikes));
      } else {
        for (const Kept& kept : kind(s - 1)) here.push_back(held.support(kept.strata));
      }
    });
    for (std::size_t s = first; s < end; ++s) {
      for (std::size_t way = 0; way < support[s - first].size(); ++way) {
        const PairingHits& hits = support[s - first][way];
        const double explained =
            s == 0 ? held.log_false_poses(lookalikes_->lookalikes, hits, lookalikes_->lengths)
                   : held.log_false_poses(kinds_[s - 1][way].strata, hits, kinds_[s - 1][way].lengths);
        most = std::max(most, explained);
        if (most >= enough) return most;
      }
    }
  }
  return most;
}

}  // namespace consimd::detail
