#include "before_and_after.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include <Eigen/Geometry>

#include <consimd/synth/problem_files.hpp>

namespace example {
namespace {

using consimd::synth::rotation_error_deg;
using consimd::synth::translation_error;

constexpr double kMaxRotationErrorDeg = 5.0;

double positive_number(const std::string& text, const char* what) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || !(value > 0.0) || value > 1e12) {
    throw std::invalid_argument(std::string(what) + " is '" + text + "', expected a number above 0");
  }
  return value;
}

Input read_files(const std::filesystem::path& path, double noise_bound) {
  return {.problem = consimd::synth::read_problem(path, path.parent_path() / "pose.txt", noise_bound),
          .noise_bound = noise_bound,
          .synthetic = false};
}

}  // namespace

Input read_input(int argc, char** argv, std::string_view about, const consimd::synth::NoiseStudyOptions& synthetic) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::string name = std::filesystem::path(argv[0]).filename();
  if (!arguments.empty() && (arguments[0] == "--help" || arguments[0] == "-h")) {
    std::printf("%.*s\n\nusage: %s [FILE NOISE_BOUND [RUNS]]\n\n", static_cast<int>(about.size()), about.data(),
                name.c_str());
    std::puts(
        "FILE         text, a row per correspondence: source xyz, target xyz; pose.txt beside it holds the true\n"
        "             pose, source to target, 4 x 4. Without arguments: a synthetic problem\n"
        "NOISE_BOUND  largest residual of an inlier, unit of the file\n"
        "RUNS         runs of each method, with other seeds where it draws at random (default 5)\n\n"
        "Exit status: 0 when the checks hold, 1 when one fails, 2 on bad usage.");
    std::exit(0);
  }
  try {
    Input input;
    if (arguments.empty()) {
      input.problem = consimd::synth::noise_study_problem(synthetic);
      input.noise_bound = consimd::synth::noise_study_bound(synthetic.sigma);
    } else {
      if (arguments.size() == 1 || arguments.size() > 3) {
        throw std::invalid_argument("usage: " + name + " [FILE NOISE_BOUND [RUNS]]; --help explains");
      }
      input = read_files(arguments[0], positive_number(arguments[1], "NOISE_BOUND"));
      if (arguments.size() == 3) {
        input.runs = static_cast<std::size_t>(std::max(1.0, positive_number(arguments[2], "RUNS")));
      }
    }
    const std::size_t size = input.problem.size();
    if (size < 3) throw std::invalid_argument(arguments[0] + ": fewer than three correspondences");
    const auto inliers = std::count(input.problem.is_inlier.begin(), input.problem.is_inlier.end(), 1);
    std::printf("%s: %zu correspondences, %.1f %% of them inliers, noise bound %g\n",
                arguments.empty() ? "synthetic" : arguments[0].c_str(), size,
                100.0 * static_cast<double>(inliers) / static_cast<double>(size), input.noise_bound);
    return input;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
    std::exit(2);
  }
}

double distance(const std::vector<double>& points, std::uint32_t i, std::uint32_t j) {
  return (Eigen::Map<const Eigen::Vector3d>(&points[std::size_t{3} * i]) -
          Eigen::Map<const Eigen::Vector3d>(&points[std::size_t{3} * j]))
      .norm();
}

consimd::RigidTransform least_squares_pose(const consimd::synth::Problem& problem,
                                           std::span<const std::uint32_t> rows) {
  Eigen::Matrix3Xd source(3, rows.size()), target(3, rows.size());
  Eigen::Index column = 0;
  for (const std::uint32_t row : rows) {
    source.col(column) = Eigen::Map<const Eigen::Vector3d>(&problem.source[std::size_t{3} * row]);
    target.col(column++) = Eigen::Map<const Eigen::Vector3d>(&problem.target[std::size_t{3} * row]);
  }
  consimd::RigidTransform pose;
  pose.matrix() = Eigen::umeyama(source, target, /*with_scaling=*/false);
  return pose;
}

consimd::RigidTransform refit(const Input& input, consimd::RigidTransform T_target_source) {
  const consimd::synth::Problem& problem = input.problem;
  for (int round = 0; round < 5; ++round) {
    std::vector<std::uint32_t> supporters;
    for (std::uint32_t row = 0; row < problem.size(); ++row) {
      const Eigen::Map<const Eigen::Vector3d> p(&problem.source[std::size_t{3} * row]);
      const Eigen::Map<const Eigen::Vector3d> q(&problem.target[std::size_t{3} * row]);
      if ((T_target_source * p - q).norm() < input.noise_bound) supporters.push_back(row);
    }
    if (supporters.size() < 3) break;
    T_target_source = least_squares_pose(problem, supporters);
  }
  return T_target_source;
}

bool is_good(const Input& input, const consimd::RigidTransform& T_target_source) {
  const consimd::RigidTransform& truth = input.problem.T_target_source;
  return rotation_error_deg(T_target_source, truth) < kMaxRotationErrorDeg &&
         translation_error(T_target_source, truth) < input.noise_bound;
}

bool all_good(const Input& input, const Method& method) {
  return std::all_of(method.runs.begin(), method.runs.end(),
                     [&](const Run& run) { return is_good(input, run.T_target_source); });
}

bool same_poses(const Method& a, const Method& b) {
  return std::equal(a.runs.begin(), a.runs.end(), b.runs.begin(), b.runs.end(), [](const Run& x, const Run& y) {
    return x.T_target_source.matrix() == y.T_target_source.matrix();
  });
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void print_table(const Input& input, std::span<const Method> methods) {
  std::printf("\n%-32s %10s %14s %17s %10s %9s\n%-32s %10s %14s %17s %10s\n", "", "good poses", "rotation error",
              "translation error", "time", "speed-up", "medians", "", "deg", "unit of the file", "ms");
  double first_ms = 0.0;
  for (const Method& method : methods) {
    std::vector<double> rotation, translation, ms;
    std::size_t good = 0;
    for (const Run& run : method.runs) {
      rotation.push_back(rotation_error_deg(run.T_target_source, input.problem.T_target_source));
      translation.push_back(translation_error(run.T_target_source, input.problem.T_target_source));
      ms.push_back(1e3 * run.seconds);
      good += is_good(input, run.T_target_source) ? 1 : 0;
    }
    const double method_ms = median(ms);
    if (&method == &methods.front()) first_ms = method_ms;
    const std::string share = std::to_string(good) + "/" + std::to_string(method.runs.size());
    std::printf("%-32s %10s %14.3f %17.3f %10.2f %8.1fx\n", method.name.c_str(), share.c_str(), median(rotation),
                median(translation), method_ms, first_ms / method_ms);
  }
  std::puts("");
}

bool check(bool holds, std::string_view what) {
  std::printf("%s: %.*s\n", holds ? "holds" : "FAILS", static_cast<int>(what.size()), what.data());
  return holds;
}

}  // namespace example
