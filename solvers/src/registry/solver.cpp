#include <consimd/solvers/solver.hpp>

#include <stdexcept>
#include <string>
#include <utility>

#include <consimd/solvers/threads.hpp>

#include "call/distinct_rows.hpp"
#include "call/refusal.hpp"
#include "call/stage_clock.hpp"
#include "noise_bound/bound_attempts.hpp"
#include "noise_bound/bound_search.hpp"
#include "registry/filtered_registration.hpp"
#include "support/independent_rows.hpp"
#include "verdict/another_scale.hpp"
#include "verdict/distortion.hpp"
#include "verdict/pose_test.hpp"

namespace consimd {
namespace {

constexpr Filter kFilters[] = {Filter::none, Filter::tcf};

Registration run(const SolverCall& solver, const Correspondences& correspondences, double noise_bound,
                 std::uint32_t bounds_tried, const SolverOptions& options) {
  const auto solve = [&](const Correspondences& rows) { return solver(rows, noise_bound, bounds_tried); };
  if (options.filter == Filter::none) return solve(correspondences);
  return detail::register_filtered(correspondences, noise_bound, bounds_tried, options.seed, solve);
}

}  // namespace

std::string_view to_string(Filter filter) noexcept { return filter == Filter::tcf ? "tcf" : "none"; }

Filter filter_by_name(std::string_view name) {
  std::string known;
  for (const Filter filter : kFilters) {
    if (to_string(filter) == name) return filter;
    known.append(known.empty() ? "" : ", ").append(to_string(filter));
  }
  throw std::invalid_argument("filter is '" + std::string(name) + "', expected one of: " + known);
}

namespace {

// A search that the condition has ended may have missed a better pose.
void note_stop(bool stopped, Registration& result) {
  result.stopped = result.stopped || stopped;
  if (result.stopped && result.status == Status::success) result.status = Status::budget_exhausted;
}

// Takes the place of a registration that found nothing, or nothing at a bound to rely on, after its stages.
void fall_back_on(Registration other, Registration& result) {
  if (!other.has_pose()) return;
  note_stop(result.stopped, other);
  other.seconds += result.seconds;
  other.stages.insert(other.stages.begin(), result.stages.begin(), result.stages.end());
  result = std::move(other);
}

void require_scale_can_be_estimated(const SolverOptions& options) {
  if (!options.noise_bound) throw std::invalid_argument("estimate_scale: needs a noise_bound");
  if (options.filter != Filter::none) {
    throw std::invalid_argument("estimate_scale: filter '" + std::string(to_string(options.filter)) +
                                "' needs a known scale, expected none");
  }
}

}  // namespace

Registration register_by_choice(SolverChoice choice, const Correspondences& correspondences, SolverOptions options) {
  if (options.estimate_scale && !choice.estimates_scale()) {
    require_scale_estimation(choice);
    choice.set("estimate_scale", true);
  }
  options.estimate_scale = choice.estimates_scale();
  return register_with(
      [&](const Correspondences& rows, double noise_bound, std::uint32_t bounds_tried) {
        return choice.run(
            rows,
            {.noise_bound = noise_bound, .seed = options.seed, .bounds_tried = bounds_tried, .stop = options.stop});
      },
      correspondences, options);
}

Registration register_by_name(std::string_view solver, const Correspondences& correspondences,
                              const SolverOptions& options) {
  return register_by_choice(SolverChoice(solver), correspondences, options);
}

namespace {

// What a pose at an estimated bound is asked beside.
void refuse_by_its_bound(const Correspondences& correspondences, Registration& result) {
  if (result.has_pose() &&
      (detail::hides_another_scale(correspondences, result.T_target_source, result.noise_bound) ||
       detail::hides_a_distortion(correspondences, result.T_target_source, result.noise_bound) ||
       detail::is_chance_at_its_noise(correspondences, result.T_target_source, result.noise_bound))) {
    detail::refuse(result);
  }
}

// A distortion within a given bound. Copies tell no more of it than the row that they are copies of.
void refuse_distorted(const Correspondences& correspondences, Registration& result) {
  if (!result.has_pose()) return;
  const detail::DistinctRows distinct(correspondences);
  if (detail::hides_a_distortion(distinct.correspondences(), result.T_target_source, result.noise_bound)) {
    detail::refuse(result);
  }
}

// A degenerate pose may be that of one place, seen again and again.
bool found_nothing(const Registration& result) {
  return result.status == Status::no_consensus || result.status == Status::degenerate_geometry;
}

// Rows that stand for all of them, registered where all of them have told nothing.
void try_independent_rows(const SolverCall& solver, const Correspondences& correspondences,
                          const SolverOptions& options, StageReport& estimation, Registration& result) {
  detail::IndependentRows found;
  {
    const detail::StageClock clock(estimation.seconds);
    found = detail::search_independent_bound(correspondences, options.seed, options.stop);
  }
  note_stop(options.stop.met(), result);
  if (found.rows.empty()) return;
  const Correspondences independent = correspondences.subset(found.rows);
  const NoiseBoundEstimate& estimate = found.estimate;
  Registration other = run(solver, independent, estimate.noise_bound, estimate.bounds_tried, options);
  note_stop(other.stopped, result);
  refuse_by_its_bound(independent, other);
  detail::bring_to_all_rows(correspondences, estimate.bounds_tried, other);
  refuse_by_its_bound(correspondences, other);
  if (!other.has_pose()) result.seconds += other.seconds;
  fall_back_on(std::move(other), result);
}

// Does the same at a noise bound that is given, where rows are few or two thirds of them recur: else a search takes as
// long again, and among rows that do not recur it has been made.
void try_independent_rows_at(double noise_bound, const SolverCall& solver, const Correspondences& correspondences,
                             const SolverOptions& options, Registration& result) {
  const std::vector<std::uint32_t> rows = detail::rows_for_another_search(correspondences.view(), result.noise_bound);
  const bool most_recur = 3 * rows.size() <= correspondences.size();
  if (rows.empty() || !(most_recur || correspondences.size() <= detail::kFewRows)) return;
  constexpr std::uint32_t kTries = 2;
  Registration other = run(solver, correspondences.subset(rows), noise_bound, kTries, options);
  note_stop(other.stopped, result);
  detail::bring_to_all_rows(correspondences, kTries, other);
  refuse_distorted(correspondences, other);
  if (!other.has_pose()) result.seconds += other.seconds;
  fall_back_on(std::move(other), result);
}

Registration register_in_arena(const SolverCall& solver, const Correspondences& correspondences,
                               const SolverOptions& options) {
  if (options.noise_bound) {
    Registration result = run(solver, correspondences, *options.noise_bound, 1, options);
    if (!options.estimate_scale) refuse_distorted(correspondences, result);
    if (!result.stopped && found_nothing(result) && !options.estimate_scale) {
      try_independent_rows_at(*options.noise_bound, solver, correspondences, options, result);
    }
    return result;
  }
  StageReport estimation{detail::kNoiseBoundStage, correspondences.size(), 0, 0, 0.0};
  detail::BoundSearch found;
  {
    const detail::StageClock clock(estimation.seconds);
    found = detail::search_noise_bound(correspondences, options.seed, options.stop);
  }
  const NoiseBoundEstimate& estimate = found.estimate;
  Registration result = run(solver, correspondences, estimate.noise_bound, estimate.bounds_tried, options);
  if (result.status == Status::no_consensus && !found.poses.empty()) {
    fall_back_on(detail::register_tried_poses(correspondences, found, options.seed), result);
  }
  refuse_by_its_bound(correspondences, result);
  // A bound that no pose was significant at is hardly that of one.
  const bool rests_on_nothing = estimate.log10_false_poses >= detail::kSignificant;
  if (!result.stopped && (found_nothing(result) || rests_on_nothing)) {
    try_independent_rows(solver, correspondences, options, estimation, result);
  }
  estimation.output = result.inliers.size();
  estimation.iterations = estimate.bounds_tried;
  result.seconds += estimation.seconds;
  result.stages.insert(result.stages.begin(), std::move(estimation));
  return result;
}

}  // namespace

Registration register_with(const SolverCall& solver, const Correspondences& correspondences,
                           const SolverOptions& options) {
  if (options.estimate_scale) require_scale_can_be_estimated(options);
  Registration result;
  run_on_threads(options.threads, [&] { result = register_in_arena(solver, correspondences, options); });
  return result;
}

}  // namespace consimd
