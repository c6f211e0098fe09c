// The engine of the noise study.
#pragma once

#include <functional>
#include <string>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/trial_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

struct SweepControl {
  /// Called as trials end, one call at a time, from any thread of the arena, before the record enters the table.
  std::function<void(const TrialRecord&)> on_trial = {};
  /// Told how an outside program failed, and on which problem, before `on_trial` gets that trial.
  std::function<void(const std::string&)> on_failure = {};
  /// Asked before every problem, from any thread; true ends the sweep once the running problems are done.
  std::function<bool()> stop_requested = {};
};

/// Runs the trials that `table` wants and lacks, in parallel over problems in the caller's arena, and fills the table.
///
/// The data of trial k depend on (seed, condition without its bound factor, outlier ratio, sigma, k) alone, so every
/// solver sees the same bytes; solvers run with seed + k and the bound 3 sigma times the bound factor. Where they are
/// to estimate it, outside solvers are given consimd's estimate. A pose succeeds where the true inliers' RMSE is below
/// 3 sigma; in families whose noise is not Gaussian, where the mean square is less than 6 sigma^2 above the oracle's,
/// which is the same for Gaussian noise: there the oracle's is 3 sigma^2 of the 9 sigma^2. Results do not depend on the
/// number of threads or on what `table` held before. Outside solvers are called from the arena's threads, several at
/// once; what one throws, and a wrong answer (see `run_outside`), end the sweep with that exception once the running
/// problems are done. Problems start in rounds of one trial of every cell: a study stopped early covers all cells
/// evenly, and the time left can be told from the time passed.
void run_sweep(TrialTable& table, const SweepControl& control = {});

}  // namespace studies
}  // namespace consimd
