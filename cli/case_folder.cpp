#include "case_folder.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "number_table.hpp"
#include "pose_file.hpp"

namespace consimd::cli {
namespace fs = std::filesystem;
namespace {

constexpr const char* kCorrespondences = "correspondences.txt";
constexpr const char* kPose = "pose.txt";
constexpr const char* kCase = "case.json";

nlohmann::json read_json(const fs::path& path) {
  std::ifstream file(path);
  nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object()) throw std::runtime_error(fmt::format("{}: expected a JSON object", path.string()));
  return json;
}

double positive_number(const nlohmann::json& json, const char* key, const fs::path& path) {
  const auto found = json.find(key);
  const double value = found != json.end() && found->is_number() ? found->get<double>() : 0.0;
  if (value > 0.0 && std::isfinite(value)) return value;
  throw std::runtime_error(fmt::format("{}: expected a number above 0 as {}", path.string(), key));
}

std::string text(const nlohmann::json& json, const char* key, const fs::path& path) {
  const auto found = json.find(key);
  if (found == json.end()) return {};
  if (found->is_string()) return found->get<std::string>();
  throw std::runtime_error(fmt::format("{}: expected a text as {}", path.string(), key));
}

synth::Problem read_problem(const fs::path& folder, double noise_bound) {
  const fs::path path = folder / kCorrespondences;
  const NumberTable table = read_number_table(path, 6);
  if (table.rows() < 3) {
    throw std::runtime_error(
        fmt::format("{}: expected at least 3 correspondences, got {}", path.string(), table.rows()));
  }
  synth::Problem problem;
  problem.T_target_source = read_pose(folder / kPose);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double* const numbers = table.values.data() + 6 * row;
    problem.source.insert(problem.source.end(), numbers, numbers + 3);
    problem.target.insert(problem.target.end(), numbers + 3, numbers + 6);
    const Eigen::Map<const Eigen::Vector3d> source(numbers), target(numbers + 3);
    problem.is_inlier.push_back((problem.T_target_source * source - target).norm() < noise_bound ? 1 : 0);
  }
  return problem;
}

studies::PoseLimits limits_of(const nlohmann::json& json, const fs::path& path, std::string_view dataset,
                              std::string_view preset) {
  try {
    if (const auto limits = studies::preset_limits(preset, dataset)) return *limits;
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), error.what()));
  }
  return {positive_number(json, "max_rotation_error_deg", path),
          positive_number(json, "max_translation_error_m", path)};
}

}  // namespace

std::vector<studies::CaseGroup> case_folder_groups(const fs::path& folder, std::uint64_t seed,
                                                   std::string_view preset) {
  std::error_code error;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory() && fs::exists(entry.path() / kCorrespondences)) folders.push_back(entry.path());
  }
  if (error) throw std::runtime_error(fmt::format("{}: cannot read: {}", folder.string(), error.message()));
  if (folders.empty()) {
    throw std::runtime_error(fmt::format("{}: no sub-folder holds a {}", folder.string(), kCorrespondences));
  }
  std::ranges::sort(folders);

  std::map<std::string, studies::CaseGroup> groups;
  for (const fs::path& of : folders) {
    for (const char* name : {kPose, kCase}) {
      if (!fs::exists(of / name)) throw std::runtime_error(fmt::format("{}: is missing", (of / name).string()));
    }
    const fs::path path = of / kCase;
    const nlohmann::json json = read_json(path);
    const std::string dataset = text(json, "dataset", path), sequence = text(json, "sequence", path);
    std::string group = dataset.empty() ? (folder / "").parent_path().filename().string() : dataset;
    if (!sequence.empty()) group += " " + sequence;
    const double noise_bound = positive_number(json, "noise_bound", path);
    groups[group].cases.push_back({.name = of.filename().string(),
                                   .noise_bound = noise_bound,
                                   .seed = seed,
                                   .limits = limits_of(json, path, dataset, preset),
                                   .load = [of, noise_bound] { return read_problem(of, noise_bound); }});
  }
  std::vector<studies::CaseGroup> result;
  for (auto& [name, group] : groups) {
    group.name = name;
    group.provenance = fmt::format("files of the folder {}", (folder / "").parent_path().filename().string());
    result.push_back(std::move(group));
  }
  return result;
}

}  // namespace consimd::cli
