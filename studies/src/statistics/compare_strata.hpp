// How solvers are compared, whatever the problems are: stratum by stratum, and strata together.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <consimd/studies/solver_comparison.hpp>

namespace consimd::studies::detail {

/// A solver's run on a problem.
struct ComparedRun {
  bool success = false;
  double limit_ratio = 0.0;         ///< error over the limit of success; infinite without a pose
  double rotation_error_deg = 0.0;  ///< counts where it succeeded, as the next one does
  double translation_error = 0.0;
  double oracle_rotation_error_deg = 0.0;  ///< NaN where there is no oracle, as the next one
  double oracle_translation_error = 0.0;
  double seconds = 0.0;
};

/// A solver's runs on all problems of a stratum: those on the first one, on the second one, and so on.
struct SolverRuns {
  std::string solver;
  std::vector<ComparedRun> runs;
};

/// Problems of one kind, and the solvers that have run on all of them.
template <typename Cell>
struct Stratum {
  Cell cell;
  std::size_t pool = 0;  ///< number of the strata that it is told together with
  std::size_t runs_per_problem = 1;
  std::vector<SolverRuns> solvers;

  [[nodiscard]] const std::vector<ComparedRun>* runs_of(const std::string& solver) const {
    const auto found = std::ranges::find(solvers, solver, &SolverRuns::solver);
    return found == solvers.end() ? nullptr : &found->runs;
  }
};

/// What is known of a pair's differences: their sums, and the sums in every sample of the bootstrap. Those of several
/// strata add up, which is the bootstrap within each stratum.
class PairTally {
 public:
  PairTally() = default;
  /// Runs of both on the same problems. `key` names the stratum among others.
  PairTally(std::span<const ComparedRun> a, std::span<const ComparedRun> b, std::size_t runs_per_problem,
            std::uint64_t seed, std::uint64_t key);

  void add(const PairTally& other);
  /// Without Holm's adjustment, for which all pairs are needed.
  [[nodiscard]] PairStatistics statistics() const;

 private:
  /// A difference of the two: its sum over the problems that have one, and in the samples of the bootstrap.
  struct Quantity {
    std::size_t problems = 0;
    double sum = 0.0;
    std::vector<double> samples = {};

    void add(const Quantity& other);
    [[nodiscard]] Estimate mean() const;
  };

  std::uint64_t problems_ = 0, only_a_ = 0, only_b_ = 0;
  Quantity recall_, rotation_deg_, translation_, log_seconds_;
};

[[nodiscard]] SolverStatistics solver_statistics(std::span<const ComparedRun> runs);

/// From half of the limit of success to three times as much.
[[nodiscard]] std::vector<CurvePoint> success_curve(std::span<const ComparedRun> runs);

/// Sets the p-values of Holm.
void adjust(const std::vector<PairStatistics*>& pairs);

template <typename Row>
void adjust_rows(std::vector<Row>& pairs) {
  std::vector<PairStatistics*> all;
  all.reserve(pairs.size());
  for (Row& pair : pairs) all.push_back(&pair);
  adjust(all);
}

/// Every pair of solvers on the strata that both have run on. `pools`: the cells of what is told together, by number.
/// Curves are of pools, and of single strata as well if `curves_of_strata`.
template <typename Cell>
[[nodiscard]] SolverComparison<Cell> compare_strata(const std::vector<Stratum<Cell>>& strata,
                                                    const std::vector<Cell>& pools, std::uint64_t seed,
                                                    bool curves_of_strata) {
  std::vector<std::string> solvers;
  for (const Stratum<Cell>& stratum : strata) {
    for (const SolverRuns& one : stratum.solvers) {
      if (std::ranges::find(solvers, one.solver) == solvers.end()) solvers.push_back(one.solver);
    }
  }
  SolverComparison<Cell> of_strata, of_pools;
  for (auto a = solvers.begin(); a != solvers.end(); ++a) {
    for (auto b = std::next(a); b != solvers.end(); ++b) {
      std::vector<std::pair<bool, PairTally>> together(pools.size());
      for (std::size_t k = 0; k < strata.size(); ++k) {
        const std::vector<ComparedRun>*of_a = strata[k].runs_of(*a), *of_b = strata[k].runs_of(*b);
        if (of_a == nullptr || of_b == nullptr) continue;
        const PairTally tally(*of_a, *of_b, strata[k].runs_per_problem, seed, k);
        of_strata.pairs.push_back({tally.statistics(), strata[k].cell, *a, *b});
        together[strata[k].pool].first = true;
        together[strata[k].pool].second.add(tally);
      }
      for (std::size_t pool = 0; pool < pools.size(); ++pool) {
        if (together[pool].first) of_pools.pairs.push_back({together[pool].second.statistics(), pools[pool], *a, *b});
      }
    }
  }
  adjust_rows(of_strata.pairs);
  adjust_rows(of_pools.pairs);

  const auto add_curve = [](SolverComparison<Cell>& to, const std::vector<ComparedRun>& runs, const Cell& cell,
                            const std::string& solver) {
    for (const CurvePoint& point : success_curve(runs)) to.curves.push_back({point, cell, solver});
  };
  for (const std::string& solver : solvers) {
    std::vector<std::vector<ComparedRun>> together(pools.size());
    for (const Stratum<Cell>& stratum : strata) {
      const std::vector<ComparedRun>* runs = stratum.runs_of(solver);
      if (runs == nullptr) continue;
      of_strata.solvers.push_back({solver_statistics(*runs), stratum.cell, solver});
      if (curves_of_strata) add_curve(of_strata, *runs, stratum.cell, solver);
      together[stratum.pool].insert(together[stratum.pool].end(), runs->begin(), runs->end());
    }
    for (std::size_t pool = 0; pool < pools.size(); ++pool) {
      if (together[pool].empty()) continue;
      of_pools.solvers.push_back({solver_statistics(together[pool]), pools[pool], solver});
      add_curve(of_pools, together[pool], pools[pool], solver);
    }
  }
  std::ranges::move(of_pools.pairs, std::back_inserter(of_strata.pairs));
  std::ranges::move(of_pools.solvers, std::back_inserter(of_strata.solvers));
  std::ranges::move(of_pools.curves, std::back_inserter(of_strata.curves));
  return of_strata;
}

}  // namespace consimd::studies::detail
