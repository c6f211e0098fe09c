#include <consimd/studies/sweep.hpp>

#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

namespace consimd::studies {
namespace {

/// One synthetic problem and the solvers that have yet to see it.
struct Job {
  double outlier_ratio;
  double sigma;
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
    const std::size_t levels = options.sigmas.size();
    for (; position_ < problems_; ++position_) {
      const std::size_t cell = position_ % (problems_ / options.trials);
      const auto trial = static_cast<std::uint32_t>(position_ / (problems_ / options.trials));
      const std::size_t ratio = cell / levels, sigma = cell % levels;
      if (!table_.wants(ratio, sigma, trial)) continue;
      Job job{options.outlier_ratios[ratio], options.sigmas[sigma], trial, {}};
      for (std::size_t solver = 0; solver < options.solvers.size(); ++solver) {
        if (!table_.has(solver, ratio, sigma, trial)) job.solvers.push_back(options.solvers[solver]);
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

std::vector<Trial> run_job(const Job& job, const SweepOptions& options) {
  // Outside solvers may keep the points.
  const auto shared =
      std::make_shared<const synth::Problem>(synth::noise_study_problem({.correspondences = options.points,
                                                                         .outlier_ratio = job.outlier_ratio,
                                                                         .sigma = job.sigma,
                                                                         .seed = options.seed,
                                                                         .trial = job.trial}));
  const synth::Problem& problem = *shared;
  const Correspondences correspondences = problem.correspondences();
  const RigidTransform& truth = problem.T_target_source;
  const RigidTransform oracle = synth::oracle(problem);

  std::vector<Trial> trials;
  for (const std::string& solver : job.solvers) {
    const std::uint64_t seed = options.seed + job.trial;
    const double bound = synth::noise_study_bound(job.sigma);
    const OutsideSolver* outside = find_outside(options.outside, solver);
    const Outcome result =
        outside == nullptr
            ? outcome_of(register_by_name(solver, correspondences,
                                          {.noise_bound = bound, .seed = seed, .filter = options.filter}))
            : run_outside(*outside, {.problem = shared,
                                     .correspondences = correspondences,
                                     .noise_bound = bound,
                                     .seed = seed,
                                     .filter = options.filter,
                                     .name = fmt::format("trial {} at outlier ratio {} and sigma {}", job.trial,
                                                         job.outlier_ratio, job.sigma)});
    const RigidTransform& pose = result.T_target_source;
    const double rmse = synth::rmse_true_inliers(problem, pose, result.scale);
    const synth::InlierQuality quality = synth::inlier_quality(problem, result.kept);
    trials.push_back({.record = {.solver = solver,
                                 .outlier_ratio = job.outlier_ratio,
                                 .sigma = job.sigma,
                                 .trial = job.trial,
                                 .seed = seed,
                                 .status = result.status,
                                 .success = result.has_pose && rmse < 3.0 * job.sigma,
                                 .rmse_true_inliers = rmse,
                                 .rotation_error_deg = synth::rotation_error_deg(pose, truth),
                                 .translation_error = synth::translation_error(pose, truth),
                                 .oracle_rotation_error_deg = synth::rotation_error_deg(oracle, truth),
                                 .oracle_translation_error = synth::translation_error(oracle, truth),
                                 .inlier_precision = quality.precision,
                                 .inlier_recall = quality.recall,
                                 .seconds = result.seconds},
                      .failure = result.failure});
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
    std::vector<Trial> trials = tbb::this_task_arena::isolate([&] { return run_job(*job, table.options()); });
    const std::lock_guard lock(filing);
    for (auto& [record, failure] : trials) {
      if (control.on_failure && !failure.empty()) control.on_failure(failure);
      if (control.on_trial) control.on_trial(record);
      table.put(std::move(record));
    }
  });
}

}  // namespace consimd::studies
