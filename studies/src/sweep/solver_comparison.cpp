#include <consimd/studies/solver_comparison.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/solvers/registration.hpp>

#include "files/csv_rows.hpp"

namespace consimd::studies {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLevel = 0.05;         // of significance
constexpr double kShortestTime = 1e-9;  // seconds: a program may say 0, which has no logarithm
constexpr std::uint32_t kFirstThreshold = 10, kLastThreshold = 60;  // twentieths of the study's own

using Trials = std::span<const TrialRecord* const>;

auto level_of(const TrialRecord& t) {
  return std::tie(t.family, t.scale, t.points, t.bound_factor, t.outlier_ratio, t.sigma);
}
auto ratio_of(const TrialRecord& t) { return std::tie(t.family, t.scale, t.points, t.bound_factor, t.outlier_ratio); }

ProblemCell cell_of(const TrialRecord& trial, bool all_levels) {
  return {trial.family,       trial.scale,         trial.points,
          trial.bound_factor, trial.outlier_ratio, all_levels ? kNaN : trial.sigma};
}

bool has_pose(const TrialRecord& trial) {
  return trial.status == to_string(Status::success) || trial.status == to_string(Status::ambiguous) ||
         trial.status == to_string(Status::budget_exhausted);
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

/// First and one past last of what is equal in `key`, one after the other.
struct Range {
  std::size_t first, end;
};
template <typename Key>
std::vector<Range> ranges_of(const std::vector<const TrialRecord*>& trials, const Key& key) {
  std::vector<Range> ranges;
  for (std::size_t k = 0; k < trials.size(); ++k) {
    if (k == 0 || key(*trials[k]) != key(*trials[k - 1])) ranges.push_back({k, k});
    ranges.back().end = k + 1;
  }
  return ranges;
}

/// What a pair's difference is taken of: recall, rotation, translation, logarithm of time.
constexpr std::size_t kQuantities = 4;
double difference(const TrialRecord& a, const TrialRecord& b, std::size_t quantity) {
  switch (quantity) {
    case 0:
      return static_cast<double>(a.success) - static_cast<double>(b.success);
    case 1:
      return a.rotation_error_deg - b.rotation_error_deg;
    case 2:
      return a.translation_error - b.translation_error;
    default:
      return elementary::log(std::max(a.seconds, kShortestTime)) - elementary::log(std::max(b.seconds, kShortestTime));
  }
}

/// A pair's differences on some trials: their sums, and the sums in every sample. Those of several noise levels add up,
/// which is the bootstrap within each level.
struct PairSums {
  std::size_t trials = 0, only_a = 0, only_b = 0;
  std::array<double, kQuantities> sums{};
  std::array<std::vector<double>, kQuantities> samples;

  void add(const PairSums& other) {
    trials += other.trials;
    only_a += other.only_a;
    only_b += other.only_b;
    for (std::size_t q = 0; q < kQuantities; ++q) {
      sums[q] += other.sums[q];
      samples[q].resize(other.samples[q].size());
      std::ranges::transform(samples[q], other.samples[q], samples[q].begin(), std::plus<>());
    }
  }
};

PairSums sums_of(Trials a, Trials b, const BootstrapMeans& bootstrap) {
  PairSums result;
  result.trials = a.size();
  std::vector<double> values(a.size());
  for (std::size_t q = 0; q < kQuantities; ++q) {
    for (std::size_t k = 0; k < a.size(); ++k) {
      values[k] = difference(*a[k], *b[k], q);
      result.sums[q] += values[k];
    }
    result.samples[q] = bootstrap.of(values);
    for (double& mean : result.samples[q]) mean *= static_cast<double>(a.size());
  }
  for (std::size_t k = 0; k < a.size(); ++k) {
    result.only_a += a[k]->success && !b[k]->success;
    result.only_b += b[k]->success && !a[k]->success;
  }
  return result;
}

PairRecord record_of(PairSums sums, ProblemCell cell, const std::string& a, const std::string& b) {
  PairRecord record{.cell = std::move(cell),
                    .a = a,
                    .b = b,
                    .trials = sums.trials,
                    .only_a = sums.only_a,
                    .only_b = sums.only_b,
                    .p_value = mcnemar_p_value(sums.only_a, sums.only_b)};
  const std::array<Estimate*, kQuantities> estimates{&record.recall, &record.rotation_deg, &record.translation,
                                                     &record.time_ratio};
  const auto count = static_cast<double>(sums.trials);
  for (std::size_t q = 0; q < kQuantities; ++q) {
    for (double& sum : sums.samples[q]) sum /= count;
    *estimates[q] = {sums.sums[q] / count, bootstrap_interval(std::move(sums.samples[q]))};
  }
  Estimate& ratio = record.time_ratio;
  ratio = {elementary::exp(ratio.value), {elementary::exp(ratio.interval.low), elementary::exp(ratio.interval.high)}};
  return record;
}

void adjust(std::span<PairRecord> pairs) {
  std::vector<double> p_values;
  for (const PairRecord& pair : pairs) p_values.push_back(pair.p_value);
  const std::vector<double> adjusted = holm_adjusted(p_values);
  for (std::size_t k = 0; k < pairs.size(); ++k) pairs[k].p_value_holm = adjusted[k];
}

std::vector<PairRecord> pairs_of(const std::vector<SolverTrials>& solvers, std::uint64_t seed) {
  std::vector<PairRecord> of_levels, of_ratios;
  for (std::size_t i = 0; i < solvers.size(); ++i) {
    for (std::size_t j = i + 1; j < solvers.size(); ++j) {
      const std::vector<const TrialRecord*>&a = solvers[i].trials, &b = solvers[j].trials;
      const std::vector<Range> levels = ranges_of(a, level_of);
      std::size_t level = 0;
      for (const Range& ratio : ranges_of(a, ratio_of)) {
        PairSums together;
        for (; level < levels.size() && levels[level].end <= ratio.end; ++level) {
          const auto [first, end] = levels[level];
          PairSums sums = sums_of(Trials(a).subspan(first, end - first), Trials(b).subspan(first, end - first),
                                  BootstrapMeans(end - first, seed, level));
          together.add(sums);
          of_levels.push_back(
              record_of(std::move(sums), cell_of(*a[first], false), solvers[i].solver, solvers[j].solver));
        }
        of_ratios.push_back(
            record_of(std::move(together), cell_of(*a[ratio.first], true), solvers[i].solver, solvers[j].solver));
      }
    }
  }
  adjust(of_levels);
  adjust(of_ratios);
  of_levels.insert(of_levels.end(), of_ratios.begin(), of_ratios.end());
  return of_levels;
}

/// Sums of squared errors.
struct PoseSquares {
  double rotation = 0.0, translation = 0.0;

  void add(double rotation_error, double translation_error) {
    rotation += rotation_error * rotation_error;
    translation += translation_error * translation_error;
  }
};

SolverRecord record_of(Trials trials, ProblemCell cell, const std::string& solver) {
  std::vector<double> rotations, translations, seconds;
  PoseSquares mine, oracle;
  for (const TrialRecord* trial : trials) {
    rotations.push_back(trial->success ? trial->rotation_error_deg : kInfinity);
    translations.push_back(trial->success ? trial->translation_error : kInfinity);
    seconds.push_back(trial->success ? trial->seconds : kInfinity);
    if (!trial->success) continue;
    mine.add(trial->rotation_error_deg, trial->translation_error);
    oracle.add(trial->oracle_rotation_error_deg, trial->oracle_translation_error);
  }
  return {.cell = std::move(cell),
          .solver = solver,
          .trials = trials.size(),
          .rotation_deg_median = quantile(rotations, 0.5),
          .rotation_deg_p90 = quantile(rotations, 0.9),
          .translation_median = quantile(translations, 0.5),
          .translation_p90 = quantile(translations, 0.9),
          .rotation_efficiency = oracle.rotation / mine.rotation,
          .translation_efficiency = oracle.translation / mine.translation,
          .seconds_recall_50 = quantile(seconds, 0.5),
          .seconds_recall_90 = quantile(seconds, 0.9),
          .seconds_recall_99 = quantile(seconds, 0.99)};
}

void add_curve(std::vector<CurveRecord>& curves, Trials trials, const std::string& solver) {
  std::vector<double> quotients;  // RMSE over the limit
  for (const TrialRecord* trial : trials) {
    const double limit = trial->rmse_limit > 0.0 ? trial->rmse_limit : 3.0 * trial->sigma;
    quotients.push_back(has_pose(*trial) ? trial->rmse_true_inliers / limit : kInfinity);
  }
  std::ranges::sort(quotients);
  for (std::uint32_t twentieths = kFirstThreshold; twentieths <= kLastThreshold; ++twentieths) {
    const double threshold = twentieths / 20.0;
    const auto below = static_cast<std::size_t>(std::ranges::lower_bound(quotients, threshold) - quotients.begin());
    curves.push_back({.cell = cell_of(*trials.front(), true),
                      .solver = solver,
                      .threshold = threshold,
                      .recall = static_cast<double>(below) / static_cast<double>(trials.size()),
                      .recall_interval = wilson_interval(below, trials.size())});
  }
}

std::string name_of(const ProblemCell& cell) {
  std::string name = fmt::format("{:.4g} % outliers", 100.0 * cell.outlier_ratio);
  if (cell.family != "gaussian") name = cell.family + ", " + name;
  if (cell.scale != "known") name += ", scale " + cell.scale;
  if (cell.bound_factor != "1") name += ", bound factor " + cell.bound_factor;
  return fmt::format("{}, {} points", name, cell.points);
}

template <typename Columns, typename Row>
std::string table_text(const Columns& columns, const std::vector<Row>& rows) {
  std::string text = csv_header(columns) + "\n";
  for (const Row& row : rows) text += csv_row(columns, row);
  return text;
}

}  // namespace

SolverComparison compare_solvers(const std::vector<TrialRecord>& trials, std::uint64_t seed) {
  const std::vector<SolverTrials> solvers = by_solver(trials);
  SolverComparison comparison{.pairs = pairs_of(solvers, seed), .solvers = {}, .curves = {}};
  std::vector<SolverRecord> of_ratios;
  for (const auto& [solver, mine] : solvers) {
    for (const auto& [first, end] : ranges_of(mine, level_of)) {
      comparison.solvers.push_back(
          record_of(Trials(mine).subspan(first, end - first), cell_of(*mine[first], false), solver));
    }
    for (const auto& [first, end] : ranges_of(mine, ratio_of)) {
      const Trials together = Trials(mine).subspan(first, end - first);
      of_ratios.push_back(record_of(together, cell_of(*mine[first], true), solver));
      add_curve(comparison.curves, together, solver);
    }
  }
  comparison.solvers.insert(comparison.solvers.end(), of_ratios.begin(), of_ratios.end());
  return comparison;
}

std::string verdict(const PairRecord& pair) {
  if (!std::isnan(pair.cell.sigma) || pair.p_value_holm > kLevel) return {};
  const bool a = pair.only_a > pair.only_b;
  return fmt::format("{}: {} beats {} ({} problems to {}, p = {:.2g}, Holm's {:.2g})", name_of(pair.cell),
                     a ? pair.a : pair.b, a ? pair.b : pair.a, std::max(pair.only_a, pair.only_b),
                     std::min(pair.only_a, pair.only_b), pair.p_value, pair.p_value_holm);
}

std::string pairs_csv(const SolverComparison& comparison) { return table_text(kPairColumns, comparison.pairs); }
std::string solvers_csv(const SolverComparison& comparison) { return table_text(kSolverColumns, comparison.solvers); }
std::string curves_csv(const SolverComparison& comparison) { return table_text(kCurveColumns, comparison.curves); }

}  // namespace consimd::studies
