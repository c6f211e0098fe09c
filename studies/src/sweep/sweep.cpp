#include <consimd/studies/sweep.hpp>

#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <consimd/solvers/noise_bound.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/problem_families.hpp>

namespace consimd::studies {
namespace {

/// One synthetic problem and the solvers that have yet to see it.
struct Job {
  TrialTable::Cell cell;
  std::uint32_t trial;
  std::vector<std::string> solvers;
};

/// The problems of a table that have yet to be run, in rounds of one trial of every cell.
class MissingProblems {
 public:
  explicit MissingProblems(const TrialTable& table)
      : table_(table), problems_(table.slots() / table.options().solvers.size()) {}

  /// The next one; none if there are no more. The table must not be filled meanwhile.
  std::optional<Job> next() {
    const SweepOptions& options = table_.options();
    for (; position_ < problems_; ++position_) {
      const std::size_t cell = position_ % table_.problem_cells();
      const auto trial = static_cast<std::uint32_t>(position_ / table_.problem_cells());
      if (!table_.wants(cell, trial)) continue;
      Job job{table_.problem_cell(cell), trial, {}};
      for (std::size_t solver = 0; solver < options.solvers.size(); ++solver) {
        if (!table_.has(solver, cell, trial)) job.solvers.push_back(options.solvers[solver]);
      }
      if (job.solvers.empty()) continue;
      ++position_;
      return job;
    }
    return std::nullopt;
  }

 private:
  const TrialTable& table_;
  std::size_t problems_;
  std::size_t position_ = 0;
};

struct Trial {
  TrialRecord record;
  std::string failure;  // of an outside program
};

/// The scale of the source where it is unknown: from 0.5 to 2, evenly spread over the trials.
double unknown_scale(std::uint32_t trial) {
  constexpr double kGolden = 0.6180339887498949;  // multiples of it, modulo 1, are spread as evenly as can be
  const double multiple = kGolden * (trial + 1.0);
  return 0.5 + 1.5 * (multiple - std::floor(multiple));
}

synth::Problem problem_of(const Job& job, const SweepOptions& options) {
  const auto& [condition, outlier_ratio, sigma] = job.cell;
  synth::NoiseStudyOptions problem{.correspondences = condition.points,
                                   .outlier_ratio = outlier_ratio,
                                   .sigma = sigma,
                                   .seed = options.seed,
                                   .trial = job.trial,
                                   .scale = condition.scale == ScaleKnowledge::known ? 1.0 : unknown_scale(job.trial)};
  if (!options.has_true_pose(job.trial)) {
    // All outliers; the ratio of the cell goes into the trial, so that cells have problems of their own.
    problem.trial |= std::uint64_t{std::bit_cast<std::uint32_t>(static_cast<float>(outlier_ratio))} << 32U;
    problem.outlier_ratio = 1.0;
  }
  return synth::family_problem(condition.family, problem);
}

std::string name_of(const Job& job, const SweepOptions& options) {
  const Condition& condition = job.cell.condition;
  const std::string at =
      fmt::format("trial {} at outlier ratio {} and sigma {}", job.trial, job.cell.outlier_ratio, job.cell.sigma);
  return options.beyond_paper() ? fmt::format("{} of family {} with {} points and bound factor {}", at,
                                              condition.family, condition.points, to_string(condition.bound_factor))
                                : at;
}

/// What a solver made of a problem, and with which noise bound.
struct Answer {
  Outcome outcome;
  double noise_bound;
};

class SolverCalls {
 public:
  SolverCalls(const Job& job, const SweepOptions& options)
      : options_(options),
        condition_(job.cell.condition),
        seed_(options.seed + job.trial),
        name_(name_of(job, options)),
        // Outside solvers may keep the points.
        problem_(std::make_shared<const synth::Problem>(problem_of(job, options))),
        correspondences_(problem_->correspondences()) {
    if (condition_.bound_factor) bound_ = *condition_.bound_factor * synth::noise_study_bound(job.cell.sigma);
  }

  [[nodiscard]] const synth::Problem& problem() const { return *problem_; }
  [[nodiscard]] std::uint64_t seed() const { return seed_; }

  [[nodiscard]] Answer call(const std::string& solver) const {
    if (const OutsideSolver* outside = find_outside(options_.outside, solver)) {
      const double bound = bound_ ? *bound_ : estimate_noise_bound(correspondences_, seed_).noise_bound;
      return {run_outside(*outside, {.problem = problem_,
                                     .correspondences = correspondences_,
                                     .noise_bound = bound,
                                     .seed = seed_,
                                     .filter = options_.filter,
                                     .name = name_}),
              bound};
    }
    Registration result = register_by_name(solver, correspondences_,
                                           {.noise_bound = bound_,
                                            .seed = seed_,
                                            .filter = options_.filter,
                                            .estimate_scale = condition_.scale == ScaleKnowledge::unknown});
    const double bound = result.noise_bound;
    return {outcome_of(std::move(result)), bound};
  }

 private:
  const SweepOptions& options_;
  const Condition& condition_;
  std::uint64_t seed_;
  std::string name_;
  std::shared_ptr<const synth::Problem> problem_;
  Correspondences correspondences_;
  std::optional<double> bound_;
};

/// The RMSE of the true inliers below which a pose succeeds.
double rmse_limit(const TrialTable::Cell& cell, double oracle_rmse) {
  if (synth::problem_family(cell.condition.family).gaussian_noise) return 3.0 * cell.sigma;
  return std::sqrt(oracle_rmse * oracle_rmse + 6.0 * cell.sigma * cell.sigma);
}

std::string_view outcome_name(const Outcome& result, bool success) {
  if (!result.has_pose) return kRefused;
  if (result.status == to_string(Status::ambiguous)) return kAmbiguous;
  return success ? kRight : kWrong;
}

std::vector<Trial> run_job(const Job& job, const SweepOptions& options) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const SolverCalls calls(job, options);
  const auto& [condition, outlier_ratio, sigma] = job.cell;
  const synth::Problem& problem = calls.problem();
  const bool true_pose = options.has_true_pose(job.trial);
  const RigidTransform& truth = problem.T_target_source;
  const RigidTransform oracle = synth::oracle(problem);
  const double oracle_rmse = true_pose ? synth::rmse_true_inliers(problem, oracle, problem.scale) : kNaN;
  const double limit = true_pose ? rmse_limit(job.cell, oracle_rmse) : kNaN;

  std::vector<Trial> trials;
  for (const std::string& solver : job.solvers) {
    const Answer answer = calls.call(solver);
    const Outcome& result = answer.outcome;
    const RigidTransform& pose = result.T_target_source;
    const auto error = [&](double of_pose) { return true_pose ? of_pose : kNaN; };
    const double rmse = synth::rmse_true_inliers(problem, pose, result.scale);
    const bool success = true_pose && result.has_pose && rmse < limit;
    const synth::InlierQuality quality = synth::inlier_quality(problem, result.kept);
    trials.push_back({.record = {.solver = solver,
                                 .outlier_ratio = outlier_ratio,
                                 .sigma = sigma,
                                 .trial = job.trial,
                                 .seed = calls.seed(),
                                 .status = result.status,
                                 .success = success,
                                 .rmse_true_inliers = error(rmse),
                                 .rotation_error_deg = error(synth::rotation_error_deg(pose, truth)),
                                 .translation_error = error(synth::translation_error(pose, truth)),
                                 .oracle_rotation_error_deg = error(synth::rotation_error_deg(oracle, truth)),
                                 .oracle_translation_error = error(synth::translation_error(oracle, truth)),
                                 .inlier_precision = quality.precision,
                                 .inlier_recall = quality.recall,
                                 .seconds = result.seconds},
                      .failure = result.failure});
    if (!options.beyond_paper()) continue;
    TrialRecord& record = trials.back().record;
    record.family = condition.family;
    record.scale = to_string(condition.scale);
    record.points = condition.points;
    record.bound_factor = to_string(condition.bound_factor);
    record.true_pose = true_pose;
    record.outcome = outcome_name(result, success);
    record.rmse_limit = limit;
    record.oracle_rmse_true_inliers = oracle_rmse;
    record.scale_error = error(synth::scale_error(result.scale, problem.scale));
    record.noise_bound = answer.noise_bound;
  }
  return trials;
}

}  // namespace

void run_sweep(TrialTable& table, const SweepControl& control) {
  MissingProblems missing(table);
  std::mutex filing;                                       // of the table, and of what is missing in it
  const std::size_t most = table.size() - table.filled();  // problems: each has a trial or more
  tbb::parallel_for(std::size_t{0}, most, [&](std::size_t) {
    if (control.stop_requested && control.stop_requested()) return;
    // The next in turn, not that of the loop's index: the loop hands out indices from several ends at once.
    std::optional<Job> job;
    {
      const std::lock_guard lock(filing);
      job = missing.next();
    }
    if (!job) return;
    // Isolated: a thread that waits inside a solver must not pick up another problem, whose time would count as this
    // one's.
    std::vector<Trial> trials;
    try {
      trials = tbb::this_task_arena::isolate([&] { return run_job(*job, table.options()); });
    } catch (const SolverStopped&) {
      return;
    }
    const std::lock_guard lock(filing);
    for (auto& [record, failure] : trials) {
      if (control.on_failure && !failure.empty()) control.on_failure(failure);
      if (control.on_trial) control.on_trial(record);
      table.put(std::move(record));
    }
  });
}

}  // namespace consimd::studies
