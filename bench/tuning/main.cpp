// What each constant of the default search is worth: every one of them multiplied by two factors, over cells of the
// noise study and, where CONSIMD_TEST_DATA names them, recorded pairs. Prints a table in Markdown.
//   consimd_tuning [RUNS [NAME [LOW HIGH]]]    runs a cell or pair (12), constants whose name contains NAME (all), the
//                                              factors (0.7 and 1.4)
#include <oneapi/tbb/task_arena.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <consimd/kernels/isa.hpp>

#include "cpu_time.hpp"
#include "registration_tasks.hpp"
#include "tcf/tuned_tcf.hpp"
#include "tuning_constants.hpp"

namespace consimd::bench {
namespace {

struct Cell {
  double outlier_ratio;
  double sigma;  // metres
};
// From the easy ones to the limit of what can be found.
constexpr Cell kCells[] = {{0.5, 1.0},  {0.9, 5.0},  {0.95, 2.5}, {0.98, 1.0},
                           {0.98, 5.0}, {0.99, 2.5}, {0.99, 5.0}, {0.995, 1.0}};

struct Run {
  std::shared_ptr<const RegistrationTask> task;
  std::uint64_t seed = 1;
};

std::vector<Run> make_runs(std::uint64_t runs_each) {
  std::vector<Run> runs;
  for (const Cell& cell : kCells) {
    for (std::uint64_t trial = 0; trial < runs_each; ++trial) {
      runs.push_back({std::make_shared<const RegistrationTask>(
                          noise_study_task({.outlier_ratio = cell.outlier_ratio, .sigma = cell.sigma, .trial = trial})),
                      trial});
    }
  }
  for (const std::filesystem::path& folder : recorded_pairs()) {
    const auto task = std::make_shared<const RegistrationTask>(recorded_task(folder));
    for (std::uint64_t seed = 1; seed <= runs_each; ++seed) runs.push_back({task, seed});
  }
  return runs;
}

struct Outcome {
  Registration registration;
  bool found = false;
  double error = 0.0;
  double seconds = 0.0;
};

Outcome measure(const Run& run, const detail::TcfTuning& tuning) {
  Outcome outcome;
  const double start = thread_seconds();
  outcome.registration = detail::register_tuned_tcf(run.task->correspondences,
                                                    {.noise_bound = run.task->noise_bound, .seed = run.seed}, tuning);
  outcome.seconds = thread_seconds() - start;
  outcome.found = outcome.registration.has_pose() && run.task->found(outcome.registration.T_target_source);
  if (outcome.found) outcome.error = run.task->error(outcome.registration.T_target_source);
  return outcome;
}

/// A tuning held against the one as constructed, run by run, both one after the other.
struct Comparison {
  int found = 0;         // runs more than before that find the pose
  int lost = 0;          // that do no more
  int changed = 0;       // runs whose status or pose is another
  double error = 1.0;    // ratio, geometric mean over the runs that find the pose both ways
  double seconds = 1.0;  // ratio of CPU times, geometric mean over all runs
};

Comparison compare(const std::vector<Run>& runs, const detail::TcfTuning& tuning) {
  Comparison result;
  double log_error = 0.0;
  double log_seconds = 0.0;
  int both = 0;
  for (const Run& run : runs) {
    // Who goes first finds colder caches.
    const bool after_first = (&run - runs.data()) % 2 == 1;
    Outcome after;
    if (after_first) after = measure(run, tuning);
    const Outcome before = measure(run, {});
    if (!after_first) after = measure(run, tuning);
    result.found += after.found && !before.found ? 1 : 0;
    result.lost += before.found && !after.found ? 1 : 0;
    const bool same = before.registration.status == after.registration.status &&
                      before.registration.T_target_source.matrix() == after.registration.T_target_source.matrix();
    result.changed += same ? 0 : 1;
    log_seconds += std::log(after.seconds / before.seconds);
    if (!before.found || !after.found || before.error == 0.0 || after.error == 0.0) continue;
    log_error += std::log(after.error / before.error);
    ++both;
  }
  if (both > 0) result.error = std::exp(log_error / both);
  result.seconds = std::exp(log_seconds / static_cast<double>(runs.size()));
  return result;
}

std::string columns(const Comparison& c) {
  return fmt::format("{} | +{} -{} | {:.3f} | {:.2f}", c.changed, c.found, c.lost, c.error, c.seconds);
}

void print_table(std::uint64_t runs_each, std::string_view name, const std::array<double, 2>& factors) {
  const std::vector<Run> runs = make_runs(runs_each);
  int found = 0;
  for (const Run& run : runs) found += measure(run, {}).found ? 1 : 0;
  fmt::print("{} runs, {} of them find the pose; {} on one thread.\n\n", runs.size(), found, to_string(active_isa()));
  fmt::print(
      "| constant | value | x {}: changed | found | error | time | x {}: changed | found | error | time |\n"
      "| --- | --: | --: | --: | --: | --: | --: | --: | --: | --: |\n",
      factors[0], factors[1]);
  for (const TuningConstant& constant : tuning_constants()) {
    if (constant.name.find(name) == std::string::npos) continue;
    fmt::print("| {} | {:.4g}", constant.name, constant.value({}));
    for (const double factor : factors) {
      detail::TcfTuning tuning;
      constant.scale(tuning, factor);
      fmt::print(" | {}", columns(compare(runs, tuning)));
    }
    fmt::print(" |\n");
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace consimd::bench

int main(int argc, char** argv) try {
  const unsigned long runs_each = argc > 1 ? std::stoul(argv[1]) : 12;
  if (runs_each == 0) throw std::invalid_argument("RUNS is 0, expected a number above 0");
  tbb::task_arena arena(1);
  const double low = argc > 4 ? std::stod(argv[3]) : 0.7;
  const double high = argc > 4 ? std::stod(argv[4]) : 1.4;
  arena.execute([&] { consimd::bench::print_table(runs_each, argc > 2 ? argv[2] : "", {low, high}); });
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "consimd_tuning: %s\n", error.what());
  return 2;
}
