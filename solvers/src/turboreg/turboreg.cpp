#include <consimd/solvers/turboreg.hpp>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <consimd/kernels/three_point_fit.hpp>

#include "scale/rival_scale.hpp"
#include "search/consensus_search.hpp"
#include "search/matrix_sample.hpp"
#include "support/hypothesis_selection.hpp"
#include "turboreg/turboreg_options.hpp"
#include "verdict/final_pose.hpp"
#include "verdict/pose_checks.hpp"

namespace consimd {
namespace {

constexpr std::size_t kFitsPerTask = 64;

std::vector<WorkingPose> fit(const Correspondences& correspondences, std::span<const IndexTriple> triples) {
  std::vector<WorkingPose> poses(triples.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triples.size(), kFitsPerTask), [&](const auto& range) {
    three_point_fits(correspondences, triples.subspan(range.begin(), range.size()),
                     std::span(poses).subspan(range.begin(), range.size()));
  });
  return poses;
}

void solve(const Correspondences& correspondences, const TurboRegOptions& options, Registration& result) {
  const double tau = options.noise_bound;
  const std::size_t size = correspondences.size();
  StageReport compatibility{"compatibility", size};
  StageReport pivot_search{"pivots", size};
  StageReport clique_search{"cliques", size};

  const detail::MatrixSample sample(correspondences, 1, options.matrix_budget_bytes, options.seed);
  const Correspondences& rows = sample.correspondences();
  ConsistencyMatrix matrix;
  {
    const detail::StageClock stage_clock(compatibility.seconds);
    matrix.compute_separated(rows, options.length_tolerance * tau, options.separation * tau);
    compatibility.output = rows.size();
  }
  std::vector<IndexPair> pivots;
  {
    const detail::StageClock stage_clock(pivot_search.seconds);
    pivots = strongest_edges(matrix, options.pivots);
    pivot_search.input = rows.size();
    pivot_search.iterations = pivots.size();
  }
  detail::BestPoses poses(correspondences, tau);
  std::vector<std::uint32_t> best_set;
  {
    const detail::StageClock stage_clock(clique_search.seconds);
    // Its stages take a few milliseconds each: between them is where it can be stopped.
    result.stopped = options.stop.met();
    const std::vector<IndexTriple> cliques =
        result.stopped ? std::vector<IndexTriple>() : pivot_cliques(matrix, pivots, options.cliques_per_pivot);
    const std::vector<WorkingPose> hypotheses = fit(rows, cliques);
    if (const auto best = detail::select_pose(correspondences, hypotheses, tau, options.ranking, poses)) {
      const IndexTriple& clique = cliques[*best];
      best_set = detail::rows_agreeing_with(
          correspondences, {sample.row(clique.first), sample.row(clique.second), sample.row(clique.third)}, tau);
    }
    clique_search.output = poses.best().support.count;
    clique_search.iterations = cliques.size();
  }
  result.stages = {compatibility, pivot_search, clique_search};
  const detail::PoseTest test = {tau, options.bounds_tried};
  detail::finish_and_conclude(correspondences, test, poses, best_set, !result.stopped, result);
}

}  // namespace

Registration register_turboreg(const Correspondences& correspondences, const TurboRegOptions& options) {
  detail::require_options(detail::turboreg_options(), options);
  return detail::run_at_known_scale(correspondences, options, solve);
}

}  // namespace consimd
