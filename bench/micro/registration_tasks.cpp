#include "registration_tasks.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <consimd/synth/metrics.hpp>

#include "workload.hpp"

namespace consimd::bench {
namespace {

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

}  // namespace

RegistrationTask noise_study_task(const synth::NoiseStudyOptions& options) {
  const synth::Problem problem = synth::noise_study_problem(options);
  return {
      problem.correspondences(), eigen_cloud(problem.source, problem.target), synth::noise_study_bound(options.sigma),
      [problem](const RigidTransform& pose) { return synth::rmse_true_inliers(problem, pose) < 3.0 * problem.sigma; }};
}

std::vector<std::filesystem::path> recorded_pairs() {
  std::vector<std::filesystem::path> folders;
  const char* const data = std::getenv("CONSIMD_TEST_DATA");
  if (data == nullptr) return folders;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / "correspondences")) {
    if (std::filesystem::exists(entry.path() / "case.json")) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

RegistrationTask recorded_task(const std::filesystem::path& folder) {
  const std::vector<double> rows = read_numbers(folder / "correspondences.txt");
  const std::vector<double> pose = read_numbers(folder / "pose.txt");
  if (rows.size() % 6 != 0 || pose.size() != 16) {
    throw std::runtime_error(fmt::format("{}: expected N x 6 correspondences and a 4 x 4 pose", folder.string()));
  }
  std::vector<double> source, target;
  for (std::size_t k = 0; k < rows.size(); ++k) (k % 6 < 3 ? source : target).push_back(rows[k]);
  std::ifstream case_file(folder / "case.json");
  const nlohmann::json limits = nlohmann::json::parse(case_file);
  const double max_rotation = limits.at("max_rotation_error_deg");
  const double max_translation = limits.at("max_translation_error_m");
  RigidTransform truth;
  truth.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(pose.data());
  const std::size_t size = rows.size() / 6;
  return {Correspondences(PointSpan<double>::interleaved(source.data(), size),
                          PointSpan<double>::interleaved(target.data(), size)),
          eigen_cloud(source, target), limits.at("noise_bound"), [=](const RigidTransform& estimate) {
            return synth::rotation_error_deg(estimate, truth) <= max_rotation &&
                   synth::translation_error(estimate, truth) <= max_translation;
          }};
}

}  // namespace consimd::bench
