// What a study tells of its solvers beside each other: who solves what others do not, how precisely, and how soon.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/paired_statistics.hpp>
#include <consimd/studies/table_columns.hpp>
#include <consimd/studies/trial_record.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// An estimate with its 95 % interval.
struct Estimate {
  double value = 0.0;
  Interval interval = {};
};

/// What rows of the tables below begin with: problems that differ in their trial alone, or, where `sigma` is NaN, in
/// the noise level as well.
struct ProblemCell {
  std::string family = "gaussian";
  std::string scale = "known";
  std::uint64_t points = 0;
  std::string bound_factor = "1";
  double outlier_ratio = 0.0;
  double sigma = 0.0;
};

/// A row of pairs.csv: two solvers on the same trials, those with a true pose.
struct PairRecord {
  ProblemCell cell = {};
  std::string a;
  std::string b;
  std::uint64_t trials = 0;
  std::uint64_t only_a = 0;
  std::uint64_t only_b = 0;
  double p_value = 1.0;
  double p_value_holm = 1.0;
  Estimate recall = {};
  Estimate rotation_deg = {};
  Estimate translation = {};
  Estimate time_ratio = {};
};

/// A row of solvers.csv: a solver's precision and speed over trials with a true pose.
struct SolverRecord {
  ProblemCell cell = {};
  std::string solver;
  std::uint64_t trials = 0;
  double rotation_deg_median = 0.0;
  double rotation_deg_p90 = 0.0;
  double translation_median = 0.0;
  double translation_p90 = 0.0;
  double rotation_efficiency = 0.0;
  double translation_efficiency = 0.0;
  double seconds_recall_50 = 0.0;
  double seconds_recall_90 = 0.0;
  double seconds_recall_99 = 0.0;
};

/// A row of curves.csv: recall as a function of the limit of success.
struct CurveRecord {
  ProblemCell cell = {};
  std::string solver;
  double threshold = 0.0;
  double recall = 0.0;
  Interval recall_interval = {};
};

/// The columns of a cell in a table of `Row`.
template <typename Row>
inline constexpr std::tuple kProblemCellColumns{
    Column{"family", member_of(&Row::cell, &ProblemCell::family), "family of the problems"},
    Column{"scale", member_of(&Row::cell, &ProblemCell::scale), "whether the solver is told the scale of the source"},
    Column{"points", member_of(&Row::cell, &ProblemCell::points), "correspondences of a problem"},
    Column{"bound_factor", member_of(&Row::cell, &ProblemCell::bound_factor),
           "noise bound given over 3 sigma; estimated: none was given"},
    Column{"outlier_ratio", member_of(&Row::cell, &ProblemCell::outlier_ratio), "share of wrong correspondences"},
    Column{"sigma", member_of(&Row::cell, &ProblemCell::sigma),
           "standard deviation of an inlier's noise, metres an axis; nan: all noise levels together"},
};

/// A column of an estimate's value, and those of its interval.
[[nodiscard]] constexpr auto estimate_member(auto outer) { return member_of(outer, &Estimate::value); }
[[nodiscard]] constexpr auto low_member(auto outer) {
  return [=](auto& row) -> decltype(auto) { return ((row.*outer).interval.low); };
}
[[nodiscard]] constexpr auto high_member(auto outer) {
  return [=](auto& row) -> decltype(auto) { return ((row.*outer).interval.high); };
}

inline constexpr auto kPairColumns = std::tuple_cat(
    kProblemCellColumns<PairRecord>,
    std::tuple{
        Column{"a", &PairRecord::a, "a solver"},
        Column{"b", &PairRecord::b, "another one, later in the study's list"},
        Column{"trials", &PairRecord::trials, "problems with a true pose, each solved by both or one or none"},
        Column{"only_a", &PairRecord::only_a, "those that a alone solved"},
        Column{"only_b", &PairRecord::only_b, "those that b alone solved"},
        Column{"p_value", &PairRecord::p_value, "of McNemar's exact test that both solve equally many, two-sided"},
        Column{"p_value_holm", &PairRecord::p_value_holm,
               "adjusted by Holm for all rows of this kind, single noise levels or all together"},
        Column{"recall_difference", estimate_member(&PairRecord::recall), "recall of a less that of b"},
        Column{"recall_difference_low", low_member(&PairRecord::recall), "lower end of its 95 % bootstrap interval"},
        Column{"recall_difference_high", high_member(&PairRecord::recall), "upper end of that interval"},
        Column{"rotation_difference_deg", estimate_member(&PairRecord::rotation_deg),
               "mean rotation error of a less that of b over all trials, failures included, degrees"},
        Column{"rotation_difference_deg_low", low_member(&PairRecord::rotation_deg),
               "lower end of its 95 % bootstrap interval"},
        Column{"rotation_difference_deg_high", high_member(&PairRecord::rotation_deg), "upper end of that interval"},
        Column{"translation_difference", estimate_member(&PairRecord::translation),
               "mean translation error of a less that of b over all trials, failures included, metres"},
        Column{"translation_difference_low", low_member(&PairRecord::translation),
               "lower end of its 95 % bootstrap interval"},
        Column{"translation_difference_high", high_member(&PairRecord::translation), "upper end of that interval"},
        Column{"time_ratio", estimate_member(&PairRecord::time_ratio), "time of a over that of b, geometric mean"},
        Column{"time_ratio_low", low_member(&PairRecord::time_ratio), "lower end of its 95 % bootstrap interval"},
        Column{"time_ratio_high", high_member(&PairRecord::time_ratio), "upper end of that interval"},
    });

inline constexpr auto kSolverColumns = std::tuple_cat(
    kProblemCellColumns<SolverRecord>,
    std::tuple{
        Column{"solver", &SolverRecord::solver, "name of the solver"},
        Column{"trials", &SolverRecord::trials, "problems with a true pose"},
        Column{"rotation_error_deg_median", &SolverRecord::rotation_deg_median,
               "median over all trials, a failure counted as infinite, degrees"},
        Column{"rotation_error_deg_p90", &SolverRecord::rotation_deg_p90, "90 % quantile likewise, degrees"},
        Column{"translation_error_median", &SolverRecord::translation_median, "median likewise, metres"},
        Column{"translation_error_p90", &SolverRecord::translation_p90, "90 % quantile likewise, metres"},
        Column{"rotation_efficiency", &SolverRecord::rotation_efficiency,
               "mean square rotation error of the oracle over that of the solver, on the trials that it solved"},
        Column{"translation_efficiency", &SolverRecord::translation_efficiency,
               "mean square translation error of the oracle over that of the solver, likewise"},
        Column{"seconds_recall_50", &SolverRecord::seconds_recall_50,
               "time within which half of all trials are solved; inf: fewer are"},
        Column{"seconds_recall_90", &SolverRecord::seconds_recall_90,
               "time within which 90 % of all trials are solved"},
        Column{"seconds_recall_99", &SolverRecord::seconds_recall_99,
               "time within which 99 % of all trials are solved"},
    });

inline constexpr auto kCurveColumns = std::tuple_cat(
    kProblemCellColumns<CurveRecord>,
    std::tuple{
        Column{"solver", &CurveRecord::solver, "name of the solver"},
        Column{"threshold", &CurveRecord::threshold, "limit of success over the study's own, of the RMSE"},
        Column{"recall", &CurveRecord::recall,
               "share of the problems with a true pose whose pose has an RMSE of the true inliers below it"},
        Column{"recall_low", member_of(&CurveRecord::recall_interval, &Interval::low),
               "lower end of its 95 % Wilson interval"},
        Column{"recall_high", member_of(&CurveRecord::recall_interval, &Interval::high), "upper end of that interval"},
    });

/// The tables, those of single noise levels first, then those of all levels together.
struct SolverComparison {
  std::vector<PairRecord> pairs;
  std::vector<SolverRecord> solvers;
  std::vector<CurveRecord> curves;  ///< of all noise levels together
};

/// Made of the trials of a study: every solver with the same problems in the same order, as the rows of trials.csv have
/// them. `seed`: of the bootstrap. Solvers are compared in the order in which they come. Throws std::invalid_argument
/// if two solvers do not have the same problems.
[[nodiscard]] SolverComparison compare_solvers(const std::vector<TrialRecord>& trials, std::uint64_t seed);

/// A line for a person, as "98 % outliers: tcf beats ransac (12 problems to 1, p = 0.0034)"; empty unless a pair of all
/// noise levels together differs at the level 0.05 after Holm's adjustment.
[[nodiscard]] std::string verdict(const PairRecord& pair);

/// Texts of pairs.csv, solvers.csv and curves.csv.
[[nodiscard]] std::string pairs_csv(const SolverComparison& comparison);
[[nodiscard]] std::string solvers_csv(const SolverComparison& comparison);
[[nodiscard]] std::string curves_csv(const SolverComparison& comparison);

}  // namespace studies
}  // namespace consimd
