#include "registration_benchmarks.hpp"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>
#include <nlohmann/json.hpp>

#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

namespace consimd::bench {
namespace {

constexpr int kSeeds = 50;

/// What a registration gets, and how its result is judged.
struct Task {
  Correspondences correspondences;
  double noise_bound;
  std::function<bool(const Registration&)> found;
};

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Registration run(const Task& task, std::uint64_t seed) {
  return register_tcf(task.correspondences, {.noise_bound = task.noise_bound, .seed = seed});
}

bool same_result(const Registration& a, const Registration& b) {
  return a.status == b.status && a.inliers == b.inliers && a.T_target_source.matrix() == b.T_target_source.matrix();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? 0.0 : 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

/// task_of(k) gives the task of iteration k, with seed k + 1.
template <typename TaskOf>
void measure(benchmark::State& state, Isa isa, const TaskOf& task_of) {
  oneapi::tbb::task_arena(1).execute([&] {
    const Task& first = task_of(0);
    set_active_isa(Isa::scalar);
    const Registration reference = run(first, 1);
    set_active_isa(isa);
    if (!same_result(run(first, 1), reference)) {
      state.SkipWithError("differs from the scalar reference");
      return;
    }
    std::vector<double> seconds;
    int found = 0;
    for (auto _ : state) {
      const std::uint64_t k = seconds.size();
      const Task& task = task_of(k);
      const double start = thread_seconds();
      const Registration result = run(task, k + 1);
      seconds.push_back(thread_seconds() - start);
      state.SetIterationTime(seconds.back());
      found += task.found(result) ? 1 : 0;
    }
    state.counters["recall"] = static_cast<double>(found) / static_cast<double>(seconds.size());
    state.counters["median_ms"] = 1e3 * median(seconds);
  });
}

Task noise_study_task(double outlier_ratio, double sigma, std::uint64_t trial) {
  const synth::Problem problem =
      synth::noise_study_problem({.outlier_ratio = outlier_ratio, .sigma = sigma, .trial = trial});
  return {problem.correspondences(), synth::noise_study_bound(sigma), [problem](const Registration& result) {
            return result.has_pose() && synth::rmse_true_inliers(problem, result.T_target_source) < 3.0 * problem.sigma;
          }};
}

/// The numbers of a text file, comments aside.
std::vector<double> read_numbers(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(fmt::format("cannot read {}", path.string()));
  std::vector<double> numbers;
  for (std::string line; std::getline(file, line);) {
    std::istringstream text(line.substr(0, line.find('#')));
    for (double number = 0.0; text >> number;) numbers.push_back(number);
  }
  return numbers;
}

Task recorded_task(const std::filesystem::path& folder) {
  const std::vector<double> rows = read_numbers(folder / "correspondences.txt");
  const std::vector<double> pose = read_numbers(folder / "pose.txt");
  if (rows.size() % 6 != 0 || pose.size() != 16) {
    throw std::runtime_error(fmt::format("{}: expected N x 6 correspondences and a 4 x 4 pose", folder.string()));
  }
  std::ifstream case_file(folder / "case.json");
  const nlohmann::json limits = nlohmann::json::parse(case_file);
  const double max_rotation = limits.at("max_rotation_error_deg");
  const double max_translation = limits.at("max_translation_error_m");
  RigidTransform truth;
  truth.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(pose.data());
  const std::size_t size = rows.size() / 6;
  return {Correspondences(PointSpan<double>{rows.data(), size, 6, 1}, PointSpan<double>{rows.data() + 3, size, 6, 1}),
          limits.at("noise_bound"), [=](const Registration& result) {
            return result.has_pose() && synth::rotation_error_deg(result.T_target_source, truth) <= max_rotation &&
                   synth::translation_error(result.T_target_source, truth) <= max_translation;
          }};
}

template <typename Benchmark>
void add(const std::string& name, Benchmark run_benchmark) {
  benchmark::RegisterBenchmark(name.c_str(), run_benchmark)
      ->Iterations(kSeeds)
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

void register_registration_benchmarks() {
  const Isa isa = active_isa();
  for (const double sigma : {0.1, 1.0, 2.5, 5.0}) {
    for (const double outlier_ratio : {0.1, 0.5, 0.9, 0.95, 0.98}) {
      add(fmt::format("register_tcf/noise/outliers:{}/sigma:{}", outlier_ratio, sigma), [=](benchmark::State& state) {
        Task task;
        measure(state, isa,
                [&](std::uint64_t k) -> const Task& { return task = noise_study_task(outlier_ratio, sigma, k); });
      });
    }
  }
  const char* const data = std::getenv("CONSIMD_TEST_DATA");
  if (data == nullptr) return;
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / "correspondences")) {
    if (std::filesystem::exists(entry.path() / "case.json")) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  for (const std::filesystem::path& folder : folders) {
    add(fmt::format("register_tcf/pair/{}", folder.filename().string()), [=](benchmark::State& state) {
      const Task task = recorded_task(folder);
      measure(state, isa, [&](std::uint64_t) -> const Task& { return task; });
    });
  }
}

}  // namespace consimd::bench
