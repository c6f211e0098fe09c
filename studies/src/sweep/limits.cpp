#include <consimd/studies/limits.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <stdexcept>

#include <tbb/parallel_for.h>

#include <consimd/solvers/solver.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include "files/csv_rows.hpp"
#include "files/row_checks.hpp"

namespace consimd::studies {
namespace {

/// The share of Gaussian errors in space that are shorter than 3 sigma: the Maxwell distribution at 3, which is
/// erf(3 / sqrt(2)) - 3 sqrt(2 / pi) exp(-9 / 2).
constexpr double kShareWithinBound = 0.97070911346511177;

/// The support of the best pose that the search met, reported or not.
std::size_t best_support(const Registration& result) {
  const auto stage = std::find_if(result.stages.begin(), result.stages.end(),
                                  [](const StageReport& report) { return report.name == "three_point"; });
  if (stage == result.stages.end()) throw std::logic_error("the default solver reports no three_point stage");
  return stage->output;
}

std::size_t support(const synth::Problem& problem, const RigidTransform& pose, double bound) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < problem.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> source(problem.source.data() + 3 * i);
    const Eigen::Map<const Eigen::Vector3d> target(problem.target.data() + 3 * i);
    count += (pose * source - target).norm() < bound;
  }
  return count;
}

struct ChanceProblem {
  std::size_t best = 0;
  std::size_t fixed = 0;
};

ChanceProblem run_problem(const SweepOptions& options, double sigma, std::uint32_t trial) {
  const synth::Problem problem = synth::hard_problem({.correspondences = options.points.front(),
                                                      .outlier_ratio = 1.0,
                                                      .sigma = sigma,
                                                      .seed = options.seed,
                                                      .trial = trial});
  const double bound = synth::noise_study_bound(sigma);
  const Registration result = register_by_name(solvers().front().name, problem.correspondences(),
                                               {.noise_bound = bound, .seed = options.seed + trial});
  return {best_support(result), support(problem, problem.T_target_source, bound)};
}

}  // namespace

std::string to_csv_row(const LimitRecord& record) { return csv_row(kLimitColumns, record); }

LimitRecord parse_limit_row(std::string_view line) {
  const LimitRecord record = parse_csv_row<LimitRecord>(kLimitColumns, line);
  require_column(is_size(record.chance_support_mean), "chance_support_mean", record.chance_support_mean);
  require_column(is_size(record.fixed_support_mean), "fixed_support_mean", record.fixed_support_mean);
  require_column(is_share(record.limit_outlier_ratio), "limit_outlier_ratio", record.limit_outlier_ratio);
  return record;
}

double limit_outlier_ratio(std::size_t points, double chance_support, double fixed_support) {
  const auto n = static_cast<double>(points);
  const double of_inliers = n * kShareWithinBound - std::max(chance_support, 3.0);
  const double per_ratio = n * kShareWithinBound - fixed_support;
  if (of_inliers <= 0.0 || per_ratio <= 0.0) return 0.0;
  return std::min(1.0, of_inliers / per_ratio);
}

void require_limits(const SweepOptions& options) {
  if (!options.beyond_paper()) return;
  throw std::invalid_argument(
      "map: the limit is that of the paper's problems, expected one number of points, family gaussian, a known scale, "
      "bound factor 1 and no problems without a pose");
}

std::vector<double> limit_levels(const SweepOptions& options, const std::optional<Shard>& shard) {
  std::vector<double> levels;
  for (std::size_t i = 0; i < options.sigmas.size(); ++i) {
    if (!shard || shard->owns(i)) levels.push_back(options.sigmas[i]);
  }
  return levels;
}

std::optional<LimitRecord> measure_limit(const SweepOptions& options, double sigma, const LimitControl& control) {
  std::array<ChanceProblem, kLimitProblems> problems;
  std::atomic<bool> stopped = false;
  std::mutex reporting;
  tbb::parallel_for(std::uint32_t{0}, kLimitProblems, [&](std::uint32_t k) {
    if (control.stop_requested && control.stop_requested()) stopped = true;
    if (stopped) return;
    problems[k] = run_problem(options, sigma, k);
    const std::lock_guard lock(reporting);
    if (control.on_problem) control.on_problem();
  });
  if (stopped) return std::nullopt;

  ChanceProblem sum;
  LimitRecord record{.sigma = sigma, .problems = kLimitProblems};
  for (const ChanceProblem& problem : problems) {
    sum.best += problem.best;
    sum.fixed += problem.fixed;
    record.chance_support_max = std::max<std::uint64_t>(record.chance_support_max, problem.best);
  }
  record.chance_support_mean = static_cast<double>(sum.best) / kLimitProblems;
  record.fixed_support_mean = static_cast<double>(sum.fixed) / kLimitProblems;
  record.limit_outlier_ratio =
      limit_outlier_ratio(options.points.front(), record.chance_support_mean, record.fixed_support_mean);
  return record;
}

}  // namespace consimd::studies
