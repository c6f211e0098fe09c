// What every example does beside its subject: read a problem, compare methods in a table, check their poses.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

namespace example {

struct Input {
  consimd::synth::Problem problem;  ///< caller's frame and unit, with the true pose
  double noise_bound = 0.0;         ///< largest residual of an inlier, same unit
  std::size_t runs = 5;             ///< of each method
  bool synthetic = true;            ///< no file was given
};

/// Reads `FILE NOISE_BOUND [RUNS]`: a file of N x 6 numbers (source xyz, target xyz) and the true pose, 4 x 4, in
/// pose.txt beside it. Without arguments a problem of the noise study. Prints what it is. Ends the program with a
/// message on bad usage (exit status 2) or --help.
[[nodiscard]] Input read_input(int argc, char** argv, std::string_view about,
                               const consimd::synth::NoiseStudyOptions& synthetic);

/// Between the points of two rows of `points`, N x 3.
[[nodiscard]] double distance(const std::vector<double>& points, std::uint32_t i, std::uint32_t j);

/// Least-squares rigid motion of the given rows; Eigen's umeyama, so nothing of consimd.
[[nodiscard]] consimd::RigidTransform least_squares_pose(const consimd::synth::Problem& problem,
                                                         std::span<const std::uint32_t> rows);

/// Refits the pose to the rows within the noise bound of it, five times.
[[nodiscard]] consimd::RigidTransform refit(const Input& input, consimd::RigidTransform T_target_source);

struct Run {
  consimd::RigidTransform T_target_source = consimd::RigidTransform::Identity();
  double seconds = 0.0;
};

struct Method {
  std::string name;
  std::vector<Run> runs;
};

/// A pose is good within 5 degrees and one noise bound of the true one.
[[nodiscard]] bool is_good(const Input& input, const consimd::RigidTransform& T_target_source);

/// Prints a row for each method: good poses, median errors, median time, speed-up over the first method.
void print_table(const Input& input, std::span<const Method> methods);

[[nodiscard]] bool all_good(const Input& input, const Method& method);

/// Whether the poses of all runs have the same bits.
[[nodiscard]] bool same_poses(const Method& a, const Method& b);

/// How many tasks run at once, at most. A task holds a Running.
class TaskGauge {
 public:
  class Running {
   public:
    explicit Running(TaskGauge& gauge) : gauge_(gauge) {
      const int now = ++gauge_.running_;
      for (int seen = gauge_.most_; seen < now && !gauge_.most_.compare_exchange_weak(seen, now);) {
      }
    }
    ~Running() { --gauge_.running_; }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

   private:
    TaskGauge& gauge_;
  };
  [[nodiscard]] int most() const { return most_; }

 private:
  std::atomic<int> running_ = 0, most_ = 0;
};

/// Prints what was checked and whether it holds, and returns the latter.
bool check(bool holds, std::string_view what);

/// Seconds that `function` takes.
template <typename Function>
double seconds_of(Function&& function) {
  const auto start = std::chrono::steady_clock::now();
  function();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A middle element: of an even number the upper one.
[[nodiscard]] double median(std::vector<double> values);

}  // namespace example
