#include <consimd/studies/sweep.hpp>

#include <atomic>
#include <mutex>
#include <utility>

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

std::vector<Job> missing_jobs(const TrialTable& table) {
  const SweepOptions& options = table.options();
  std::vector<Job> jobs;
  for (std::uint32_t trial = 0; trial < options.trials; ++trial) {
    for (std::size_t ratio = 0; ratio < options.outlier_ratios.size(); ++ratio) {
      for (std::size_t sigma = 0; sigma < options.sigmas.size(); ++sigma) {
        if (!table.wants(ratio, sigma, trial)) continue;
        Job job{options.outlier_ratios[ratio], options.sigmas[sigma], trial, {}};
        for (std::size_t solver = 0; solver < options.solvers.size(); ++solver) {
          if (!table.has(solver, ratio, sigma, trial)) job.solvers.push_back(options.solvers[solver]);
        }
        if (!job.solvers.empty()) jobs.push_back(std::move(job));
      }
    }
  }
  return jobs;
}

std::vector<TrialRecord> run_job(const Job& job, const SweepOptions& options) {
  const synth::Problem problem = synth::noise_study_problem({.correspondences = options.points,
                                                             .outlier_ratio = job.outlier_ratio,
                                                             .sigma = job.sigma,
                                                             .seed = options.seed,
                                                             .trial = job.trial});
  const Correspondences correspondences = problem.correspondences();
  const RigidTransform& truth = problem.T_target_source;
  const RigidTransform oracle = synth::oracle(problem);

  std::vector<TrialRecord> records;
  for (const std::string& solver : job.solvers) {
    const std::uint64_t seed = options.seed + job.trial;
    const Registration result =
        register_by_name(solver, correspondences,
                         {.noise_bound = synth::noise_study_bound(job.sigma), .seed = seed, .filter = options.filter});
    const RigidTransform& pose = result.T_target_source;
    const double rmse = synth::rmse_true_inliers(problem, pose, result.scale);
    const synth::InlierQuality quality = synth::inlier_quality(problem, result.inliers);
    records.push_back({.solver = solver,
                       .outlier_ratio = job.outlier_ratio,
                       .sigma = job.sigma,
                       .trial = job.trial,
                       .seed = seed,
                       .status = std::string(to_string(result.status)),
                       .success = result.has_pose() && rmse < 3.0 * job.sigma,
                       .rmse_true_inliers = rmse,
                       .rotation_error_deg = synth::rotation_error_deg(pose, truth),
                       .translation_error = synth::translation_error(pose, truth),
                       .oracle_rotation_error_deg = synth::rotation_error_deg(oracle, truth),
                       .oracle_translation_error = synth::translation_error(oracle, truth),
                       .inlier_precision = quality.precision,
                       .inlier_recall = quality.recall,
                       .seconds = result.seconds});
  }
  return records;
}

}  // namespace

void run_sweep(TrialTable& table, const SweepControl& control) {
  const std::vector<Job> jobs = missing_jobs(table);
  std::atomic<std::size_t> next = 0;
  std::mutex filing;
  tbb::parallel_for(std::size_t{0}, jobs.size(), [&](std::size_t) {
    if (control.stop_requested && control.stop_requested()) return;
    // A ticket, not the loop's index: the loop hands out indices from several ends at once.
    const Job& job = jobs[next.fetch_add(1)];
    // Isolated: a thread that waits inside a solver must not pick up another problem, whose time would count as this
    // one's.
    std::vector<TrialRecord> records = tbb::this_task_arena::isolate([&] { return run_job(job, table.options()); });
    const std::lock_guard lock(filing);
    for (TrialRecord& record : records) {
      if (control.on_trial) control.on_trial(record);
      table.put(std::move(record));
    }
  });
}

}  // namespace consimd::studies
