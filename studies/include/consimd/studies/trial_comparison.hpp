// The solvers of a noise study beside each other.
#pragma once

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/solver_comparison.hpp>
#include <consimd/studies/table_columns.hpp>
#include <consimd/studies/trial_record.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Problems that differ in their trial alone, or, where `sigma` is NaN, in the noise level as well.
struct ProblemCell {
  std::string family = "gaussian";
  std::string scale = "known";
  std::uint64_t points = 0;
  std::string bound_factor = "1";
  double outlier_ratio = 0.0;
  double sigma = 0.0;

  /// Its columns in a table of `Row`.
  template <typename Row>
  [[nodiscard]] static constexpr auto columns() {
    return std::tuple{
        Column{"family", member_of(&Row::cell, &ProblemCell::family), "family of the problems"},
        Column{"scale", member_of(&Row::cell, &ProblemCell::scale),
               "whether the solver is told the scale of the source"},
        Column{"points", member_of(&Row::cell, &ProblemCell::points), "correspondences of a problem"},
        Column{"bound_factor", member_of(&Row::cell, &ProblemCell::bound_factor),
               "noise bound given over 3 sigma; estimated: none was given"},
        Column{"outlier_ratio", member_of(&Row::cell, &ProblemCell::outlier_ratio), "share of wrong correspondences"},
        Column{"sigma", member_of(&Row::cell, &ProblemCell::sigma),
               "standard deviation of an inlier's noise, metres an axis; nan: all noise levels together"},
    };
  }
};

using TrialComparison = SolverComparison<ProblemCell>;

/// Made of the trials of a study that have a true pose: every solver with the same problems in the same order, as the
/// rows of trials.csv have them. Curves are those of all noise levels together. `seed`: of the bootstrap. Solvers are
/// compared in the order in which they come. Throws std::invalid_argument if two solvers do not have the same problems.
[[nodiscard]] TrialComparison compare_solvers(const std::vector<TrialRecord>& trials, std::uint64_t seed);

/// A line for a person, as "98 % outliers: tcf beats ransac (12 problems to 1, p = 0.0034, Holm's 0.01)"; empty unless
/// the row is of all noise levels together and its solvers `differ`.
[[nodiscard]] std::string verdict(const PairRow<ProblemCell>& pair);

}  // namespace studies
}  // namespace consimd
