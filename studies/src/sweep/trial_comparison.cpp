#include <consimd/studies/trial_comparison.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include <consimd/solvers/registration.hpp>

#include "statistics/compare_strata.hpp"

namespace consimd::studies {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

auto ratio_of(const TrialRecord& t) { return std::tie(t.family, t.scale, t.points, t.bound_factor, t.outlier_ratio); }
auto level_of(const TrialRecord& t) { return std::tuple_cat(ratio_of(t), std::tie(t.sigma)); }

ProblemCell cell_of(const TrialRecord& trial, double sigma) {
  return {trial.family, trial.scale, trial.points, trial.bound_factor, trial.outlier_ratio, sigma};
}

bool has_pose(const TrialRecord& trial) {
  return trial.status == to_string(Status::success) || trial.status == to_string(Status::ambiguous) ||
         trial.status == to_string(Status::budget_exhausted);
}

detail::ComparedRun run_of(const TrialRecord& trial) {
  const double limit = trial.rmse_limit > 0.0 ? trial.rmse_limit : 3.0 * trial.sigma;
  return {.success = trial.success,
          .limit_ratio = has_pose(trial) ? trial.rmse_true_inliers / limit : kInfinity,
          .rotation_error_deg = trial.rotation_error_deg,
          .translation_error = trial.translation_error,
          .oracle_rotation_error_deg = trial.oracle_rotation_error_deg,
          .oracle_translation_error = trial.oracle_translation_error,
          .seconds = trial.seconds};
}

/// A solver's trials with a true pose.
struct SolverTrials {
  std::string solver;
  std::vector<const TrialRecord*> trials;
};

std::vector<SolverTrials> by_solver(const std::vector<TrialRecord>& trials) {
  std::vector<SolverTrials> all;
  for (const TrialRecord& trial : trials) {
    if (!trial.true_pose) continue;
    auto mine = std::ranges::find(all, trial.solver, &SolverTrials::solver);
    if (mine == all.end()) mine = all.insert(all.end(), {trial.solver, {}});
    mine->trials.push_back(&trial);
  }
  for (const SolverTrials& one : all) {
    const auto same = [](const TrialRecord* a, const TrialRecord* b) {
      return level_of(*a) == level_of(*b) && a->trial == b->trial;
    };
    if (!std::ranges::equal(one.trials, all.front().trials, same)) {
      throw std::invalid_argument(fmt::format("solvers {} and {} do not have the same problems in the same order",
                                              all.front().solver, one.solver));
    }
  }
  return all;
}

std::string name_of(const ProblemCell& cell) {
  std::string name = fmt::format("{:.4g} % outliers", 100.0 * cell.outlier_ratio);
  if (cell.family != "gaussian") name = cell.family + ", " + name;
  if (cell.scale != "known") name += ", scale " + cell.scale;
  if (cell.bound_factor != "1") name += ", bound factor " + cell.bound_factor;
  return fmt::format("{}, {} points", name, cell.points);
}

}  // namespace

TrialComparison compare_solvers(const std::vector<TrialRecord>& trials, std::uint64_t seed) {
  const std::vector<SolverTrials> solvers = by_solver(trials);
  std::vector<detail::Stratum<ProblemCell>> strata;
  std::vector<ProblemCell> pools;
  const std::size_t count = solvers.empty() ? 0 : solvers.front().trials.size();
  for (std::size_t k = 0; k < count; ++k) {
    const TrialRecord& trial = *solvers.front().trials[k];
    const TrialRecord* const before = k == 0 ? nullptr : solvers.front().trials[k - 1];
    if (before == nullptr || ratio_of(*before) != ratio_of(trial)) pools.push_back(cell_of(trial, kNaN));
    if (before == nullptr || level_of(*before) != level_of(trial)) {
      strata.push_back({.cell = cell_of(trial, trial.sigma), .pool = pools.size() - 1, .solvers = {}});
      for (const SolverTrials& one : solvers) strata.back().solvers.push_back({one.solver, {}});
    }
    for (std::size_t s = 0; s < solvers.size(); ++s) {
      strata.back().solvers[s].runs.push_back(run_of(*solvers[s].trials[k]));
    }
  }
  return detail::compare_strata(strata, pools, seed, false);
}

std::string verdict(const PairRow<ProblemCell>& pair) {
  if (!std::isnan(pair.cell.sigma) || !differ(pair)) return {};
  return fmt::format("{}: {}", name_of(pair.cell), beats(pair, pair.a, pair.b));
}

}  // namespace consimd::studies
