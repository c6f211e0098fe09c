#include "registration_benchmarks.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/tcf.hpp>

#include "cpu_time.hpp"
#include "eigen_tcf.hpp"
#include "peak_memory.hpp"
#include "registration_tasks.hpp"

namespace consimd::bench {
namespace {

constexpr int kSeeds = 50;

/// The task of iteration k, which has seed k + 1.
using TaskOf = std::function<std::shared_ptr<const RegistrationTask>(std::uint64_t k)>;

struct Attempt {
  std::optional<RigidTransform> pose;
  std::vector<StageReport> stages;
};
using Solve = std::function<Attempt(const RegistrationTask&, std::uint64_t seed)>;

void measure(benchmark::State& state, const TaskOf& task_of, const Solve& solve) {
  std::vector<double> milliseconds;
  std::map<std::string, std::vector<double>> stages;
  int found = 0;
  for (auto _ : state) {
    const std::uint64_t k = milliseconds.size();
    const std::shared_ptr<const RegistrationTask> task = task_of(k);
    const double start = thread_seconds();
    const Attempt attempt = solve(*task, k + 1);
    const double seconds = thread_seconds() - start;
    state.SetIterationTime(seconds);
    milliseconds.push_back(1e3 * seconds);
    for (const StageReport& stage : attempt.stages) stages[stage.name].push_back(1e3 * stage.seconds);
    found += attempt.pose && task->found(*attempt.pose) ? 1 : 0;
  }
  state.counters["recall"] = static_cast<double>(found) / static_cast<double>(milliseconds.size());
  state.counters["median_ms"] = median(milliseconds);
  for (const auto& [name, times] : stages) state.counters[name + "_ms"] = median(times);
}

Registration run_tcf(const RegistrationTask& task, std::uint64_t seed, std::uint32_t max_seeds) {
  return register_tcf(task.correspondences, {.noise_bound = task.noise_bound, .seed = seed, .max_seeds = max_seeds});
}

bool same_result(const Registration& a, const Registration& b) {
  return a.status == b.status && a.inliers == b.inliers && a.T_target_source.matrix() == b.T_target_source.matrix();
}

void measure_tcf(benchmark::State& state, Isa isa, const TaskOf& task_of, std::uint32_t max_seeds) {
  oneapi::tbb::task_arena(1).execute([&] {
    const std::shared_ptr<const RegistrationTask> first = task_of(0);
    set_active_isa(Isa::scalar);
    const Registration reference = run_tcf(*first, 1, max_seeds);
    set_active_isa(isa);
    Registration result;
    const std::optional<std::size_t> peak = peak_memory_bytes([&] { result = run_tcf(*first, 1, max_seeds); });
    if (!same_result(result, reference)) {
      state.SkipWithError("differs from the scalar reference");
      return;
    }
    measure(state, task_of, [max_seeds](const RegistrationTask& task, std::uint64_t seed) {
      const Registration found = run_tcf(task, seed, max_seeds);
      return Attempt{found.has_pose() ? std::optional(found.T_target_source) : std::nullopt, found.stages};
    });
    if (peak) state.counters["peak_mib"] = static_cast<double>(*peak) / (1 << 20);
  });
}

void measure_eigen(benchmark::State& state, const TaskOf& task_of, bool prune) {
  measure(state, task_of, [prune](const RegistrationTask& task, std::uint64_t seed) {
    const std::optional<EigenPose> found =
        eigen::register_tcf(task.eigen, {.noise_bound = task.noise_bound, .prune = prune, .seed = seed});
    if (!found) return Attempt{};
    RigidTransform pose = RigidTransform::Identity();
    pose.linear() = found->R;
    pose.translation() = found->t;
    return Attempt{pose, {}};
  });
}

template <typename Benchmark>
benchmark::internal::Benchmark* add(const std::string& name, int iterations, const Benchmark& run_benchmark) {
  return benchmark::RegisterBenchmark(name.c_str(), run_benchmark)
      ->Iterations(iterations)
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

void add_tcf(const std::string& name, int iterations, const TaskOf& task_of,
             std::uint32_t max_seeds = TcfOptions{}.max_seeds) {
  const Isa isa = active_isa();
  add("register_tcf/" + name, iterations,
      [=](benchmark::State& state) { measure_tcf(state, isa, task_of, max_seeds); });
}

void add_eigen(const std::string& name, int iterations, const TaskOf& task_of) {
  add("register_eigen/" + name, iterations, [=](benchmark::State& state) { measure_eigen(state, task_of, false); });
}

void add_all(const std::string& name, const TaskOf& task_of) {
  add_tcf(name, kSeeds, task_of);
  add_eigen(name, kSeeds, task_of);
  add("register_eigen_pruned/" + name, kSeeds, [=](benchmark::State& state) {
    measure_eigen(state, task_of, true);
  })->Repetitions(1);  // up to half a second for each seed
}

TaskOf noise_study_tasks(double outlier_ratio, double sigma, std::size_t size = 3000) {
  return [=](std::uint64_t k) {
    return std::make_shared<const RegistrationTask>(
        noise_study_task({.correspondences = size, .outlier_ratio = outlier_ratio, .sigma = sigma, .trial = k}));
  };
}

}  // namespace

void register_registration_benchmarks() {
  for (const double sigma : {0.1, 1.0, 2.5, 5.0}) {
    for (const double outlier_ratio : {0.1, 0.5, 0.9, 0.95, 0.98}) {
      add_all(fmt::format("noise/outliers:{}/sigma:{}", outlier_ratio, sigma), noise_study_tasks(outlier_ratio, sigma));
    }
  }
  for (const std::filesystem::path& folder : recorded_pairs()) {
    add_all("pair/" + folder.filename().string(),
            [task = std::make_shared<const RegistrationTask>(recorded_task(folder))](std::uint64_t) { return task; });
  }
  for (const int size : {1'000, 3'000, 10'000, 30'000, 100'000, 300'000, 1'000'000}) {
    const int iterations = std::clamp(1'000'000 / size, 5, kSeeds);
    const TaskOf tasks = noise_study_tasks(0.95, 0.1, static_cast<std::size_t>(size));
    add_tcf(fmt::format("size:{}", size), iterations, tasks);
    add_eigen(fmt::format("size:{}", size), iterations, tasks);
  }
  struct Cell {
    double outlier_ratio, sigma;
  };
  for (const Cell cell : {Cell{0.98, 1.0}, {0.98, 5.0}, {0.99, 2.5}, {0.995, 1.0}}) {
    for (std::uint32_t seeds = 16; seeds <= 4096; seeds *= 2) {
      add_tcf(fmt::format("budget/outliers:{}/sigma:{}/seeds:{}", cell.outlier_ratio, cell.sigma, seeds), kSeeds,
              noise_study_tasks(cell.outlier_ratio, cell.sigma), seeds);
    }
  }
}

}  // namespace consimd::bench
