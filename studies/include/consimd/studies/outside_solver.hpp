// Solvers of others in a study: a function under a name, on the same problems as consimd's own.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/studies/outcome.hpp>
#include <consimd/synth/problem.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// A problem as an outside solver is given it: N correspondences, in double precision and as the kernels read them.
struct OutsideProblem {
  const Correspondences& correspondences;
  std::span<const double> source;  ///< N x 3, row-major, unit of the problem
  std::span<const double> target;  ///< N x 3; row k is putatively the same point as row k of the source
  double noise_bound;              ///< largest residual of an inlier, same unit
  std::uint64_t seed;
  std::string_view name;               ///< for messages: "trial 3 at outlier ratio 0.5 and sigma 1"
  std::shared_ptr<const void> points;  ///< what holds source and target, for those who keep them beyond the call
};

/// What it answers. A Registration, a pose or std::nullopt (there is no pose) will do.
struct OutsideReply {
  // NOLINTBEGIN(google-explicit-constructor): a solver returns what it has.
  OutsideReply(std::nullopt_t /*no pose*/) {}
  OutsideReply(const RigidTransform& found) : pose(found) {}
  OutsideReply(const std::optional<RigidTransform>& found) : pose(found) {}
  OutsideReply(const Registration& result);
  // NOLINTEND(google-explicit-constructor)

  /// Maps source points to the target frame. Within 1e-3 an entry of R R^T it need not be a rotation yet: the nearest
  /// one counts.
  std::optional<RigidTransform> pose;
  /// Rows of the problem, each once, in any order. None: those within the noise bound of the pose.
  std::optional<std::vector<std::uint32_t>> inliers = {};
  /// As in trials.csv; empty: "success" with a pose, "no_consensus" without.
  std::string status = {};
  /// The solver's own time; none: that of the call.
  std::optional<double> seconds = {};
  /// Why there is no answer, where the solver failed: status is then one of `is_failure`.
  std::string failure = {};
};

/// What `solve` throws if it was told to stop: the problem stays undone, and the study goes on, to its own wish to
/// stop.
class SolverStopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A solver of somebody else's. All members but `solve` say which one it is: a study in a folder goes on only with the
/// same, and its summary names them.
struct OutsideSolver {
  std::string name;                  ///< in tables; see `require_outside_solvers`
  std::string command = "function";  ///< how it is called
  std::string version = {};
  double time_limit = 0.0;  ///< seconds a problem that `solve` keeps to; 0: none
  /// Called from any thread, by several at once in a sweep. What else it throws ends the study and reaches the caller
  /// of `run_sweep` or `run_comparison`. May be missing where nothing is run, as in a merge.
  std::function<OutsideReply(const OutsideProblem&)> solve = {};
};

using OutsideSolvers = std::vector<OutsideSolver>;

// Statuses of a trial on which an outside program failed.
inline constexpr std::string_view kCrashed = "crashed";
inline constexpr std::string_view kTimedOut = "timed_out";
[[nodiscard]] constexpr bool is_failure(std::string_view status) { return status == kCrashed || status == kTimedOut; }

/// How often outside programs failed.
class FailureCounts {
 public:
  /// Counts where the status is that of a failure.
  void add(std::string_view solver, std::string_view status) {
    if (is_failure(status)) ++counts_[{std::string(solver), std::string(status)}];
  }
  [[nodiscard]] bool any() const noexcept { return !counts_.empty(); }
  /// "mine: 2 crashed, 1 timed out; yours: 1 crashed"
  [[nodiscard]] std::string text() const;

 private:
  std::map<std::pair<std::string, std::string>, std::size_t> counts_;  // by solver and status
};

/// Throws std::invalid_argument unless every name is made of letters, digits, '_', '-' and '.', begins with a letter,
/// is there once and among the `listed` ones, and is no solver or method of consimd, and every time limit is a finite
/// number >= 0.
void require_outside_solvers(const OutsideSolvers& outside, const std::vector<std::string>& listed);

/// That of the name; null if it is none of these.
[[nodiscard]] const OutsideSolver* find_outside(const OutsideSolvers& outside, std::string_view name) noexcept;

/// A solver's name in tables, however its options were spelt. Throws std::invalid_argument if it is neither one of
/// `outside` nor of consimd.
[[nodiscard]] std::string solver_label(const OutsideSolvers& outside, std::string_view solver);

/// What a study asks of an outside solver.
struct OutsideTask {
  std::shared_ptr<const synth::Problem> problem;
  const Correspondences& correspondences;  ///< the problem's
  double noise_bound;
  std::uint64_t seed;
  Filter filter;
  std::string name;  ///< of the problem, for messages
};

/// Runs it, after the filter if there is one: it is then given what the filter kept, its pose stands as told, and its
/// inliers without telling are taken from all rows. Throws std::runtime_error that names solver and problem if the
/// answer is wrong: numbers that are not finite, no rotation, a reflection, inliers that are not rows, an unknown
/// status. Throws std::invalid_argument if there is nothing to call.
[[nodiscard]] Outcome run_outside(const OutsideSolver& solver, const OutsideTask& task);

}  // namespace studies
}  // namespace consimd
