#include <consimd/solvers/pcr99.hpp>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <span>

#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/kernels/length_ratio.hpp>
#include <consimd/kernels/three_point_fit.hpp>
#include <consimd/solvers/significance.hpp>

#include "pcr99/pcr99_options.hpp"
#include "scale/rival_scale.hpp"
#include "scale/scaled_registration.hpp"
#include "search/consensus_search.hpp"
#include "search/matrix_sample.hpp"
#include "support/hypothesis_selection.hpp"
#include "verdict/final_pose.hpp"
#include "verdict/pose_checks.hpp"
#include "verdict/pose_test.hpp"

namespace consimd {
namespace {

constexpr std::size_t kRowsPerTask = 64;
constexpr std::size_t kFitsPerTask = 64;
// Batches looked at for a rival among what the best pose does not explain.
constexpr std::uint32_t kRivalBatches = 2;
// ... and triples: those of a rival are among the first.
constexpr std::uint64_t kRivalTriples = 200'000'000;

void check(const Pcr99Options& options) {
  detail::require_length("noise_bound", options.noise_bound);
  detail::require_options(detail::pcr99_options(), options);
}

// So many noise bounds as a length that the kernels take.
double length_of(double tolerance, const Pcr99Options& options) {
  return std::min(tolerance * options.noise_bound, 1e300);
}

detail::PoseTest test_of(const Pcr99Options& options) { return {options.noise_bound, options.bounds_tried}; }

/// The search among some of the correspondences, best first.
class Search {
 public:
  Search(const Correspondences& correspondences, const Pcr99Options& options)
      : correspondences_(correspondences), options_(options), poses_(correspondences, options.noise_bound) {}

  /// `rows`: as many of the best-ranked ones as the matrix may have. Offers the poses of at most `batches` of triples,
  /// each one of at most `most_screened`; ends early once the best pose is significant, or stopped. Returns whether it
  /// is significant, or no triple is left.
  bool run(std::span<const std::uint32_t> rows, std::uint32_t batches, std::uint32_t most_screened,
           std::uint64_t max_triples) {
    const Correspondences ranked = correspondences_.subset(rows);
    ConsistencyMatrix matrix;
    {
      const detail::StageClock clock(pairs.seconds);
      matrix.compute_ratio(ranked, length_of(options_.length_tolerance, options_),
                           elementary::tanh(options_.ratio_tolerance));
    }
    const detail::StageClock clock(triples.seconds);
    RankedTriples order(matrix);
    std::vector<IndexTriple> batch;
    std::vector<WorkingPose> hypotheses;
    for (std::uint32_t b = 0; b < batches; ++b) {
      if (options_.stop.met()) {
        stopped_ = true;
        break;
      }
      const std::size_t wanted = std::min(options_.batch, options_.max_hypotheses - b * options_.batch);
      order.next(std::min<std::size_t>(most_screened, std::size_t{1} << std::min(b, 31U)) * wanted, max_triples, batch);
      if (batch.empty()) break;
      keep_best_connected(matrix, wanted, batch);
      triples.iterations += batch.size();
      fit(ranked, batch, hypotheses);
      const auto best = detail::select_pose(correspondences_, hypotheses, options_.noise_bound, options_.ranking,
                                            poses_, options_.inlier_tolerance);
      if (!best) continue;
      const IndexTriple& triple = batch[*best];
      best_triple_ = {rows[triple.first], rows[triple.second], rows[triple.third]};
      significant_ = is_significant();
      if (significant_) break;
    }
    pairs.iterations += order.looked_at();
    return !stopped_ && (order.done() || significant_);
  }

  /// Whether the options' condition has ended it.
  [[nodiscard]] bool stopped() const noexcept { return stopped_; }

  [[nodiscard]] const detail::BestPoses& poses() const noexcept { return poses_; }
  /// Rows that agree in length with the triple that the best pose came from.
  [[nodiscard]] std::vector<std::uint32_t> best_set() const {
    return detail::rows_agreeing_with(correspondences_, best_triple_, options_.noise_bound);
  }

  StageReport pairs{"pairs"};
  StageReport triples{"triples"};

 private:
  // As the final pose is judged.
  [[nodiscard]] bool is_significant() const {
    const detail::PoseCandidate& best = poses_.best();
    return significance(correspondences_, best.pose, options_.noise_bound).log10_false_poses +
               elementary::log10(std::max(options_.bounds_tried, 1U)) <
           detail::kSignificant;
  }

  static void fit(const Correspondences& ranked, std::span<const IndexTriple> triples,
                  std::vector<WorkingPose>& poses) {
    poses.resize(triples.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triples.size(), kFitsPerTask), [&](const auto& range) {
      three_point_fits(ranked, triples.subspan(range.begin(), range.size()),
                       std::span(poses).subspan(range.begin(), range.size()));
    });
  }

  const Correspondences& correspondences_;
  const Pcr99Options& options_;
  detail::BestPoses poses_;
  IndexTriple best_triple_{};
  bool significant_ = false;
  bool stopped_ = false;
};

void solve(const Correspondences& correspondences, const Pcr99Options& options, Registration& result) {
  const std::size_t size = correspondences.size();
  StageReport ranking{"ranking", size, size, size};
  std::vector<std::uint32_t> order(size);
  {
    const detail::StageClock stage_clock(ranking.seconds);
    const std::vector<float> costs = ranking_costs(correspondences, options);
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t row) { return costs[row]; });
  }
  const std::size_t kept = std::min(size, detail::rows_within(options.matrix_budget_bytes, 1));
  const std::uint32_t batches = (options.max_hypotheses - 1) / options.batch + 1;
  Search search(correspondences, options);
  search.pairs.input = size;
  search.pairs.output = kept;
  const bool settled = search.run(std::span(order).first(kept), batches, options.max_screened, options.max_triples);
  if (search.poses().best().support.count >= 3) {
    // The first pose that is significant ends the search: another may have as much support.
    std::vector<std::uint32_t> rest;
    for (const std::uint32_t row : order) {
      if (rest.size() < kept && !search.poses().best_explains(row)) rest.push_back(row);
    }
    search.run(rest, kRivalBatches, 1, std::min(options.max_triples, kRivalTriples));
  }
  search.triples.input = kept;
  search.triples.output = search.poses().best().support.count;
  result.stages = {ranking, search.pairs, search.triples};
  result.stopped = search.stopped();
  detail::finish_and_conclude(correspondences, test_of(options), search.poses(), search.best_set(),
                              settled && !search.stopped(), result);
}

Registration register_at_known_scale(const Correspondences& correspondences, const Pcr99Options& options) {
  return detail::run_at_known_scale(correspondences, options, solve);
}

}  // namespace

std::vector<float> ranking_costs(const Correspondences& correspondences, const Pcr99Options& options) {
  check(options);
  std::vector<std::uint32_t> rows(correspondences.size());
  std::iota(rows.begin(), rows.end(), 0U);
  std::vector<float> costs(rows.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows.size(), kRowsPerTask), [&](const auto& range) {
    length_disagreement(correspondences, std::span(rows).subspan(range.begin(), range.size()),
                        length_of(options.ranking_tolerance, options), elementary::tanh(options.ratio_tolerance),
                        std::span(costs).subspan(range.begin(), range.size()));
  });
  // A row far from all others agrees with none.
  for (const std::uint32_t row : correspondences.far_rows()) costs[row] = static_cast<float>(rows.size());
  return costs;
}

Registration register_pcr99(const Correspondences& correspondences, const Pcr99Options& options) {
  check(options);
  if (!options.estimate_scale) return register_at_known_scale(correspondences, options);
  return detail::register_scaled(correspondences, {options.noise_bound, options.seed, options.threads},
                                 options.bounds_tried, detail::Refinement::full,
                                 [&](const Correspondences& scaled, std::uint32_t tried) {
                                   Pcr99Options known = options;
                                   known.bounds_tried = tried;
                                   known.threads = 0;
                                   return register_at_known_scale(scaled, known);
                                 });
}

}  // namespace consimd
