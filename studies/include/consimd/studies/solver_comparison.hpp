// What a study or a comparison tells of its solvers beside each other: who solves what others do not, how precisely,
// and how soon.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/statistics.hpp>
#include <consimd/studies/table_columns.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

// Files of the tables in the folder of a study or a comparison.
inline constexpr std::string_view kPairsFile = "pairs.csv";
inline constexpr std::string_view kSolversFile = "solvers.csv";
inline constexpr std::string_view kCurvesFile = "curves.csv";

/// An estimate with its 95 % interval.
struct Estimate {
  double value = 0.0;
  Interval interval = {};
};

/// Two solvers on the same problems; `kPairStatisticsColumns` says what the members mean.
struct PairStatistics {
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

/// A solver's precision and speed; `kSolverStatisticsColumns` says what the members mean.
struct SolverStatistics {
  std::uint64_t trials = 0;
  double recall = 0.0;
  Interval recall_interval = {};
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

/// A point of recall as a function of the limit of success.
struct CurvePoint {
  double threshold = 0.0;
  double recall = 0.0;
  Interval recall_interval = {};
};

// Rows of pairs.csv, solvers.csv and curves.csv. `Cell` names the problems: see trial_comparison.hpp and
// method_comparison.hpp.

template <typename Cell>
struct PairRow : PairStatistics {
  Cell cell = {};
  std::string a = {};
  std::string b = {};
};

template <typename Cell>
struct SolverRow : SolverStatistics {
  Cell cell = {};
  std::string solver = {};
};

template <typename Cell>
struct CurveRow : CurvePoint {
  Cell cell = {};
  std::string solver = {};
};

/// The tables: rows of single cells first, then those of several together.
template <typename Cell>
struct SolverComparison {
  std::vector<PairRow<Cell>> pairs;
  std::vector<SolverRow<Cell>> solvers;
  std::vector<CurveRow<Cell>> curves;
};

/// A column of an estimate's value, and those of its interval.
[[nodiscard]] constexpr auto estimate_member(auto outer) { return member_of(outer, &Estimate::value); }
[[nodiscard]] constexpr auto low_member(auto outer) {
  return [=](auto& row) -> decltype(auto) { return ((row.*outer).interval.low); };
}
[[nodiscard]] constexpr auto high_member(auto outer) {
  return [=](auto& row) -> decltype(auto) { return ((row.*outer).interval.high); };
}

inline constexpr std::tuple kPairStatisticsColumns{
    Column{"trials", &PairStatistics::trials, "problems with a true pose, each solved by both or one or none"},
    Column{"only_a", &PairStatistics::only_a,
           "those that a alone solved; with several runs on a problem: in more of them than b"},
    Column{"only_b", &PairStatistics::only_b, "those that b alone solved, likewise"},
    Column{"p_value", &PairStatistics::p_value, "of McNemar's exact test that both solve equally many, two-sided"},
    Column{"p_value_holm", &PairStatistics::p_value_holm,
           "adjusted by Holm for all rows of this kind, single cells or several together"},
    Column{"recall_difference", estimate_member(&PairStatistics::recall), "recall of a less that of b"},
    Column{"recall_difference_low", low_member(&PairStatistics::recall), "lower end of its 95 % bootstrap interval"},
    Column{"recall_difference_high", high_member(&PairStatistics::recall), "upper end of that interval"},
    Column{"rotation_difference_deg", estimate_member(&PairStatistics::rotation_deg),
           "mean rotation error of a less that of b over the problems that both solved, degrees"},
    Column{"rotation_difference_deg_low", low_member(&PairStatistics::rotation_deg),
           "lower end of its 95 % bootstrap interval"},
    Column{"rotation_difference_deg_high", high_member(&PairStatistics::rotation_deg), "upper end of that interval"},
    Column{"translation_difference", estimate_member(&PairStatistics::translation),
           "mean translation error of a less that of b over the problems that both solved, unit of the problems"},
    Column{"translation_difference_low", low_member(&PairStatistics::translation),
           "lower end of its 95 % bootstrap interval"},
    Column{"translation_difference_high", high_member(&PairStatistics::translation), "upper end of that interval"},
    Column{"time_ratio", estimate_member(&PairStatistics::time_ratio), "time of a over that of b, geometric mean"},
    Column{"time_ratio_low", low_member(&PairStatistics::time_ratio), "lower end of its 95 % bootstrap interval"},
    Column{"time_ratio_high", high_member(&PairStatistics::time_ratio), "upper end of that interval"},
};

inline constexpr std::tuple kSolverStatisticsColumns{
    Column{"trials", &SolverStatistics::trials, "runs on problems with a true pose"},
    Column{"recall", &SolverStatistics::recall, "share of them that succeeded"},
    Column{"recall_low", member_of(&SolverStatistics::recall_interval, &Interval::low),
           "lower end of its 95 % Wilson interval"},
    Column{"recall_high", member_of(&SolverStatistics::recall_interval, &Interval::high), "upper end of that interval"},
    Column{"rotation_error_deg_median", &SolverStatistics::rotation_deg_median,
           "median over all trials, a failure counted as infinite, degrees"},
    Column{"rotation_error_deg_p90", &SolverStatistics::rotation_deg_p90, "90 % quantile likewise, degrees"},
    Column{"translation_error_median", &SolverStatistics::translation_median, "median likewise, unit of the problems"},
    Column{"translation_error_p90", &SolverStatistics::translation_p90, "90 % quantile likewise"},
    Column{"rotation_efficiency", &SolverStatistics::rotation_efficiency,
           "mean square rotation error of the oracle over that of the solver, on the trials that it solved"},
    Column{"translation_efficiency", &SolverStatistics::translation_efficiency,
           "mean square translation error of the oracle over that of the solver, likewise"},
    Column{"seconds_recall_50", &SolverStatistics::seconds_recall_50,
           "time within which half of all trials are solved; inf: fewer are"},
    Column{"seconds_recall_90", &SolverStatistics::seconds_recall_90,
           "time within which 90 % of all trials are solved"},
    Column{"seconds_recall_99", &SolverStatistics::seconds_recall_99,
           "time within which 99 % of all trials are solved"},
};

inline constexpr std::tuple kCurvePointColumns{
    Column{"threshold", &CurvePoint::threshold, "limit of success over the study's own"},
    Column{"recall", &CurvePoint::recall,
           "share of the trials on problems with a true pose whose error is below that limit"},
    Column{"recall_low", member_of(&CurvePoint::recall_interval, &Interval::low),
           "lower end of its 95 % Wilson interval"},
    Column{"recall_high", member_of(&CurvePoint::recall_interval, &Interval::high), "upper end of that interval"},
};

/// The columns of the rows above: those that name the cell, those that name the solvers, and the statistics.
template <typename Cell>
inline constexpr auto kPairColumns = std::tuple_cat(Cell::template columns<PairRow<Cell>>(),
                                                    std::tuple{Column{"a", &PairRow<Cell>::a, "a solver"},
                                                               Column{"b", &PairRow<Cell>::b,
                                                                      "another one, later in the list"}},
                                                    kPairStatisticsColumns);
template <typename Cell>
inline constexpr auto kSolverColumns = std::tuple_cat(Cell::template columns<SolverRow<Cell>>(),
                                                      std::tuple{Column{"solver", &SolverRow<Cell>::solver,
                                                                        "name of the solver"}},
                                                      kSolverStatisticsColumns);
template <typename Cell>
inline constexpr auto kCurveColumns =
    std::tuple_cat(Cell::template columns<CurveRow<Cell>>(),
                   std::tuple{Column{"solver", &CurveRow<Cell>::solver, "name of the solver"}}, kCurvePointColumns);

/// The level of significance of the words below.
inline constexpr double kSignificance = 0.05;

/// Whether one of the two solves more than the other, at that level after Holm's adjustment.
[[nodiscard]] bool differ(const PairStatistics& pair) noexcept;

/// "tcf beats ransac (12 problems to 1, p = 0.0034, Holm's 0.01)", whoever of the two solved more alone.
[[nodiscard]] std::string beats(const PairStatistics& pair, const std::string& a, const std::string& b);

}  // namespace studies
}  // namespace consimd
