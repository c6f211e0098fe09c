#include <consimd/solvers/mac.hpp>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <optional>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/working_length.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "mac/clique_selection.hpp"
#include "mac/mac_options.hpp"
#include "scale/rival_scale.hpp"
#include "search/consensus_search.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/final_pose.hpp"
#include "verdict/pose_checks.hpp"

namespace consimd {
namespace {

constexpr std::size_t kFitsPerTask = 16;
constexpr int kPowerIterations = 20;
// A pose is brought into place if it has this share of the best pose's score: those of small cliques are noisy. So are
// the best few, even if they are the same motion, and then so many at most that are another.
constexpr float kWorthOptimising = 0.4F;
constexpr std::size_t kFirstOptimised = 16;
constexpr std::size_t kOptimised = 48;

/// Leading eigenvector of the clique's edge weights, which are positive off the diagonal.
Eigen::VectorXd leading_eigenvector(const detail::CompatibilityGraph& graph, std::span<const std::uint32_t> clique,
                                    bool second_order) {
  const auto size = static_cast<Eigen::Index>(clique.size());
  Eigen::MatrixXd edges = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index a = 0; a < size; ++a) {
    for (Eigen::Index b = 0; b < a; ++b) {
      edges(a, b) = edges(b, a) =
          graph.weight(clique[static_cast<std::size_t>(b)], clique[static_cast<std::size_t>(a)], second_order);
    }
  }
  Eigen::VectorXd v = Eigen::VectorXd::Ones(size);
  for (int k = 0; k < kPowerIterations; ++k) {
    const Eigen::VectorXd next = edges * v;
    const double largest = next.maxCoeff();
    if (!(largest > 0.0)) return Eigen::VectorXd::Ones(size);
    v = next / largest;
  }
  return v;
}

RigidFit fit_clique(const CorrespondenceView& view, std::span<const std::uint32_t> clique,
                    const Eigen::VectorXd& weights) {
  RigidMoments m{};
  for (std::size_t i = 0; i < clique.size(); ++i) {
    const double w = weights[static_cast<Eigen::Index>(i)];
    m.weight += w;
    for (std::size_t a = 0; a < 3; ++a) {
      const double target = view.target(a)[clique[i]];
      m.source[a] += w * view.source(a)[clique[i]];
      m.target[a] += w * target;
      for (std::size_t b = 0; b < 3; ++b) m.cross[3 * a + b] += w * target * view.source(b)[clique[i]];
    }
  }
  return rigid_fit(m);
}

/// Poses of the cliques, best score first. Cliques that determine no rotation have none.
struct Hypothesis {
  detail::PoseCandidate candidate;
  std::size_t clique = 0;
};

std::vector<Hypothesis> hypotheses_of(const CorrespondenceView& view, const detail::CompatibilityGraph& graph,
                                      std::span<const detail::WeightedClique> cliques, const MacOptions& options) {
  std::vector<Hypothesis> hypotheses(cliques.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cliques.size(), kFitsPerTask), [&](const auto& range) {
    std::vector<WorkingPose> poses;
    std::vector<std::size_t> positions;
    for (std::size_t c = range.begin(); c < range.end(); ++c) {
      const std::vector<std::uint32_t>& rows = cliques[c].rows;
      const auto size = static_cast<Eigen::Index>(rows.size());
      const RigidFit fit = fit_clique(view, rows,
                                      options.weighted_fit ? leading_eigenvector(graph, rows, options.second_order)
                                                           : Eigen::VectorXd(Eigen::VectorXd::Ones(size)));
      if (!fit.determined()) continue;
      poses.push_back(to_working_pose(fit.pose));
      positions.push_back(c);
    }
    std::vector<PoseSupport> support(poses.size());
    alignment_scores(view, poses, options.noise_bound, support);
    for (std::size_t p = 0; p < poses.size(); ++p) hypotheses[positions[p]] = {{poses[p], support[p]}, positions[p]};
  });
  std::ranges::stable_sort(hypotheses, std::ranges::greater{},
                           [](const Hypothesis& h) { return h.candidate.support.score; });
  return hypotheses;
}

/// Offers the hypotheses, brought into place. Returns the clique that the best came from.
std::size_t choose(const Correspondences& correspondences, std::span<const Hypothesis> hypotheses, double noise_bound,
                   detail::BestPoses& poses) {
  std::size_t best = 0;
  std::size_t optimised = 0;
  for (const Hypothesis& hypothesis : hypotheses) {
    const float score = hypothesis.candidate.support.score;
    if (score <= kWorthOptimising * poses.best().support.score || optimised == kOptimised) break;
    if (optimised >= kFirstOptimised && poses.same_motion_as_best(hypothesis.candidate.pose)) continue;
    ++optimised;
    if (poses.offer(detail::locally_optimise(correspondences, hypothesis.candidate, noise_bound))) {
      best = hypothesis.clique;
    }
  }
  return best;
}

// Share of its supporters that each supporter of a pose is compatible with in the graph, at least: the graph's test is
// narrower than the noise.
constexpr double kCompatibleShare = 0.25;

/// Whether a pose of more support than the best may have been missed. Its rows would not be explained by the best one,
/// so many of them would have had their search cut short, and they would be compatible with one another: a core of the
/// graph.
bool may_have_missed(const detail::CompatibilityGraph& graph, std::span<const std::uint32_t> cut_short,
                     const detail::BestPoses& poses) {
  const std::uint32_t support = poses.best().support.count;
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < graph.graph().size(); ++row) {
    if (!poses.best_explains(row)) rows.push_back(row);
  }
  BitGraph unexplained;
  unexplained.assign_subgraph(graph.graph(), rows);
  const std::vector<std::uint32_t> core = core_numbers(unexplained).core;
  const auto suspect = [&](std::uint32_t row) {
    const auto place = std::ranges::lower_bound(rows, row);
    return place != rows.end() && *place == row &&
           core[static_cast<std::size_t>(place - rows.begin())] >= kCompatibleShare * support;
  };
  return std::ranges::count_if(cut_short, suspect) > support;
}

void solve(const Correspondences& correspondences, const MacOptions& options, Registration& result) {
  const CorrespondenceView view = correspondences.view();
  const std::size_t size = view.size();
  detail::require_whole_matrix(options.matrix_budget_bytes, size);

  StageReport clique_report{"maximal_cliques", size};
  StageReport hypothesis_report{"hypotheses", size};
  const double distance = working_length(view, options.compatibility_distance * options.noise_bound) / view.scale();
  std::optional<detail::CompatibilityGraph> graph;
  detail::SelectedCliques selected;
  {
    const detail::StageClock stage(clique_report.seconds);
    graph.emplace(view, distance, options.compatibility_threshold, options.max_mean_degree, options.seed);
    selected = detail::select_cliques(*graph, options);
  }
  std::vector<std::uint64_t> covered(view.words());
  for (const detail::WeightedClique& clique : selected.cliques) {
    for (const std::uint32_t row : clique.rows) covered[row / kBlock] |= std::uint64_t{1} << (row % kBlock);
  }
  clique_report.output = popcount(covered);
  clique_report.iterations = selected.found;

  detail::BestPoses poses(correspondences, options.noise_bound);
  std::vector<std::uint32_t> best_set;
  {
    const detail::StageClock stage(hypothesis_report.seconds);
    if (selected.cliques.size() > options.max_hypotheses) selected.cliques.resize(options.max_hypotheses);
    const std::vector<Hypothesis> hypotheses = hypotheses_of(view, *graph, selected.cliques, options);
    const std::size_t best = choose(correspondences, hypotheses, options.noise_bound, poses);
    if (poses.best().support.count >= 3) {
      const std::vector<std::uint32_t>& rows = selected.cliques[best].rows;
      best_set = detail::rows_agreeing_with(correspondences, {rows[0], rows[1], rows[2]}, options.noise_bound);
    }
  }
  hypothesis_report.output = poses.best().support.count;
  hypothesis_report.iterations = selected.cliques.size();

  result.stopped = selected.stopped;
  const bool confident = !selected.stopped && !may_have_missed(*graph, selected.cut_short, poses);
  result.stages = {clique_report, hypothesis_report};
  const detail::PoseTest test = {options.noise_bound, options.bounds_tried};
  detail::finish_and_conclude(correspondences, test, poses, best_set, confident, result);
}

}  // namespace

Registration register_mac(const Correspondences& correspondences, const MacOptions& options) {
  detail::require_options(detail::mac_options(), options);
  return detail::run_at_known_scale(correspondences, options, solve);
}

}  // namespace consimd
