#include <consimd/studies/outside_solver.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include <consimd/solvers/registry.hpp>
#include <consimd/solvers/tcf_filter.hpp>
#include <consimd/synth/problem_files.hpp>

#include <consimd/studies/method.hpp>
#include "files/row_checks.hpp"

namespace consimd::studies {
namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

bool is_outside_name(std::string_view name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto may_follow = [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
  };
  return !name.empty() && is_letter(name.front()) && std::ranges::all_of(name, may_follow);
}

/// Throws what is wrong with an answer.
[[noreturn]] void refuse(const OutsideSolver& solver, const OutsideTask& task, const std::string& what) {
  throw std::runtime_error(fmt::format("solver {} on {}: wrong reply: {}", solver.name, task.name, what));
}

/// The pose that counts: a rotation that is one but for the rounding of doubles stays as it is.
RigidTransform checked_pose(const RigidTransform& pose) {
  constexpr double kRounding = 1e-12;            // of a unit: no error of a study shows it
  constexpr double kLargestTranslation = 1e100;  // so that squares of errors are finite
  if (!pose.affine().allFinite()) throw std::invalid_argument("the pose has a number that is not finite");
  if (const double largest = pose.translation().cwiseAbs().maxCoeff(); largest > kLargestTranslation) {
    throw std::invalid_argument(
        fmt::format("the translation has {}, expected {} at most", largest, kLargestTranslation));
  }
  RigidTransform nearest = synth::nearest_pose(pose.linear(), pose.translation());
  const Eigen::Matrix3d product = pose.linear() * pose.linear().transpose();
  return (product - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kRounding ? pose : nearest;
}

std::vector<std::uint32_t> checked_inliers(std::vector<std::uint32_t> rows, std::size_t size) {
  std::ranges::sort(rows);
  if (!rows.empty() && rows.back() >= size) {
    throw std::invalid_argument(fmt::format("inlier {} is no row of {}", rows.back(), size));
  }
  if (const auto twice = std::ranges::adjacent_find(rows); twice != rows.end()) {
    throw std::invalid_argument(fmt::format("inlier {} is there twice", *twice));
  }
  return rows;
}

std::vector<std::uint32_t> rows_within(const synth::Problem& problem, const RigidTransform& pose, double bound) {
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < problem.size(); ++row) {
    const Eigen::Map<const Eigen::Vector3d> source(problem.source.data() + 3 * std::size_t{row});
    const Eigen::Map<const Eigen::Vector3d> target(problem.target.data() + 3 * std::size_t{row});
    if ((pose * source - target).norm() <= bound) rows.push_back(row);
  }
  return rows;
}

std::string checked_status(const OutsideReply& reply) {
  if (reply.status.empty()) return std::string(to_string(reply.pose ? Status::success : Status::no_consensus));
  if (!is_status(reply.status) || is_failure(reply.status))
    throw std::invalid_argument(fmt::format("unknown status '{}'", reply.status));
  const auto named = [&](Status status) { return reply.status == to_string(status); };
  const bool with_pose =
      named(Status::success) || named(Status::ambiguous) || named(Status::budget_exhausted);  // as Registration's
  if (with_pose != reply.pose.has_value()) {
    throw std::invalid_argument(fmt::format("status {} {} a pose", reply.status, with_pose ? "without" : "with"));
  }
  return reply.status;
}

/// Rows of a problem that lie in memory of their own.
struct Points {
  std::vector<double> source, target;
};

std::vector<double> chosen(const std::vector<double>& points, const std::vector<std::uint32_t>& rows) {
  std::vector<double> kept;
  kept.reserve(3 * rows.size());
  for (const std::uint32_t row : rows) {
    const auto first = points.begin() + 3 * static_cast<std::ptrdiff_t>(row);
    kept.insert(kept.end(), first, first + 3);
  }
  return kept;
}

OutsideReply timed_call(const OutsideSolver& solver, const OutsideProblem& problem) {
  const Clock::time_point start = Clock::now();
  OutsideReply reply = solver.solve(problem);
  if (!reply.seconds) reply.seconds = since(start);
  return reply;
}

/// The answer, its inliers as rows of the whole problem and its time with that of the filter.
OutsideReply answer(const OutsideSolver& solver, const OutsideTask& task) {
  const synth::Problem& whole = *task.problem;
  if (task.filter == Filter::none) {
    return timed_call(solver, {task.correspondences, whole.source, whole.target, task.noise_bound, task.seed, task.name,
                               task.problem});
  }
  const Clock::time_point start = Clock::now();
  const std::vector<std::uint32_t> rows =
      tcf_filter(task.correspondences, {.noise_bound = task.noise_bound, .seed = task.seed}).rows;
  const Correspondences kept = task.correspondences.subset(rows);
  const auto points = std::make_shared<const Points>(Points{chosen(whole.source, rows), chosen(whole.target, rows)});
  const double filter_seconds = since(start);
  OutsideReply reply =
      timed_call(solver, {kept, points->source, points->target, task.noise_bound, task.seed, task.name, points});
  *reply.seconds += filter_seconds;
  if (reply.inliers) {
    for (std::uint32_t& row : *reply.inliers) {
      if (row >= rows.size()) refuse(solver, task, fmt::format("inlier {} is no row of {}", row, rows.size()));
      row = rows[row];
    }
  }
  return reply;
}

}  // namespace

Outcome outcome_of(Registration result) {
  return {.status = std::string(to_string(result.status)),
          .has_pose = result.has_pose(),
          .T_target_source = result.T_target_source,
          .scale = result.scale,
          .kept = std::move(result.inliers),
          .seconds = result.seconds,
          .failure = {}};
}

OutsideReply::OutsideReply(const Registration& result) : inliers(result.inliers), status(to_string(result.status)) {
  if (result.has_pose()) pose = result.T_target_source;
}

std::string FailureCounts::text() const {
  std::string text;
  std::string_view of;
  for (const auto& [key, count] : counts_) {
    const auto& [solver, status] = key;
    if (solver == of) {
      text += ", ";
    } else {
      text += fmt::format("{}{}: ", text.empty() ? "" : "; ", solver);
    }
    of = solver;
    text += fmt::format("{} {}", count, status == kTimedOut ? "timed out" : status);
  }
  return text;
}

void require_outside_solvers(const OutsideSolvers& outside, const std::vector<std::string>& listed) {
  const std::vector<std::string> taken = solver_names();
  for (auto solver = outside.begin(); solver != outside.end(); ++solver) {
    if (!is_outside_name(solver->name)) {
      throw std::invalid_argument(fmt::format(
          "solver '{}': expected a name of letters, digits, '_', '-' and '.' that begins with a letter", solver->name));
    }
    if (std::ranges::find(taken, solver->name) != taken.end() || is_method_of_stages(solver->name)) {
      throw std::invalid_argument(fmt::format("solver {}: consimd has one of this name", solver->name));
    }
    const auto same = [&](const OutsideSolver& other) { return other.name == solver->name; };
    if (std::any_of(outside.begin(), solver, same)) {
      throw std::invalid_argument(fmt::format("solver: {} is given twice", solver->name));
    }
    if (std::ranges::find(listed, solver->name) == listed.end()) {
      throw std::invalid_argument(fmt::format("solver {}: it is not in the list of solvers", solver->name));
    }
    if (!(std::isfinite(solver->time_limit) && solver->time_limit >= 0.0)) {
      throw std::invalid_argument(
          fmt::format("solver {}: expected a time limit >= 0 s, got {}", solver->name, solver->time_limit));
    }
  }
}

const OutsideSolver* find_outside(const OutsideSolvers& outside, std::string_view name) noexcept {
  const auto found = std::ranges::find(outside, name, &OutsideSolver::name);
  return found == outside.end() ? nullptr : &*found;
}

std::string solver_label(const OutsideSolvers& outside, std::string_view solver) {
  return find_outside(outside, solver) != nullptr ? std::string(solver) : SolverChoice(solver).label();
}

Outcome run_outside(const OutsideSolver& solver, const OutsideTask& task) {
  if (!solver.solve) throw std::invalid_argument(fmt::format("solver {}: there is no function to call", solver.name));
  OutsideReply reply = answer(solver, task);
  if (!reply.failure.empty()) {
    const std::string status(is_failure(reply.status) ? std::string_view(reply.status) : kCrashed);
    return {.status = status,
            .seconds = *reply.seconds,
            .failure = fmt::format("{} on {}: {}", solver.name, task.name, reply.failure)};
  }
  try {
    if (!(std::isfinite(*reply.seconds) && *reply.seconds >= 0.0)) {
      throw std::invalid_argument(fmt::format("time {} is none", *reply.seconds));
    }
    Outcome outcome{.status = checked_status(reply), .has_pose = reply.pose.has_value(), .seconds = *reply.seconds};
    if (!reply.pose) return outcome;
    outcome.T_target_source = checked_pose(*reply.pose);
    outcome.kept = reply.inliers ? checked_inliers(std::move(*reply.inliers), task.problem->size())
                                 : rows_within(*task.problem, outcome.T_target_source, task.noise_bound);
    return outcome;
  } catch (const std::invalid_argument& error) {
    refuse(solver, task, error.what());
  }
}

}  // namespace consimd::studies
