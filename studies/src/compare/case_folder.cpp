#include <consimd/studies/case_folder.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <consimd/synth/problem_files.hpp>
#include <consimd/synth/text_file.hpp>

#include "files/digest.hpp"
#include "files/json_text.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

constexpr const char* kCorrespondences = "correspondences.txt";
constexpr const char* kPose = "pose.txt";
constexpr const char* kCase = "case.json";
constexpr const char* kMaxRotation = "max_rotation_error_deg";
constexpr const char* kMaxTranslation = "max_translation_error_m";

Json read_object(const fs::path& path) {
  const std::string text = synth::read_text(path);
  try {
    Json json = parse_json(text);
    if (!json.is_object()) throw std::invalid_argument("expected a JSON object");
    return json;
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

std::optional<double> positive_number(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) return std::nullopt;
  const double value = found->get<double>();
  return value > 0.0 && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

double required(const std::optional<double>& number, const char* key, const fs::path& path) {
  if (number) return *number;
  throw std::runtime_error(fmt::format("{}: expected a number above 0 as {}", path.string(), key));
}

std::string text(const Json& json, const char* key, const fs::path& path) {
  const auto found = json.find(key);
  if (found == json.end()) return {};
  if (found->is_string()) return found->get<std::string>();
  throw std::runtime_error(fmt::format("{}: expected a text as {}", path.string(), key));
}

PoseLimits limits_of(const CaseFile& file, const fs::path& path, std::string_view preset) {
  try {
    if (const auto limits = preset_limits(preset, file.dataset)) return *limits;
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), error.what()));
  }
  return file.limits(path);
}

std::string digest_of(const fs::path& folder) {
  Digest digest;
  for (const char* name : {kCorrespondences, kPose, kCase}) digest.add(synth::read_text(folder / name));
  return digest.text();
}

CaseData load(const fs::path& folder, double noise_bound, std::string_view digest) {
  synth::Problem problem = synth::read_problem(folder / kCorrespondences, folder / kPose, noise_bound);
  if (digest_of(folder) != digest) {
    throw std::runtime_error(fmt::format("{}: its files have changed since the comparison began", folder.string()));
  }
  return {std::move(problem), noise_bound};
}

}  // namespace

PoseLimits CaseFile::limits(const fs::path& path) const {
  return {required(max_rotation_error_deg, kMaxRotation, path), required(max_translation_error, kMaxTranslation, path)};
}

CaseFile read_case_file(const fs::path& path) {
  const Json json = read_object(path);
  return {.noise_bound = required(positive_number(json, "noise_bound"), "noise_bound", path),
          .max_rotation_error_deg = positive_number(json, kMaxRotation),
          .max_translation_error = positive_number(json, kMaxTranslation),
          .dataset = text(json, "dataset", path),
          .sequence = text(json, "sequence", path)};
}

std::vector<CaseGroup> case_folder_groups(const fs::path& folder, std::uint64_t seed, std::string_view preset) {
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

  std::map<std::string, CaseGroup> groups;
  for (const fs::path& recorded : folders) {
    for (const char* name : {kPose, kCase}) {
      if (!fs::exists(recorded / name))
        throw std::runtime_error(fmt::format("{}: is missing", (recorded / name).string()));
    }
    const fs::path path = recorded / kCase;
    const CaseFile file = read_case_file(path);
    std::string group = file.dataset.empty() ? (folder / "").parent_path().filename().string() : file.dataset;
    if (!file.sequence.empty()) group += " " + file.sequence;
    std::string digest = digest_of(recorded);
    groups[group].cases.push_back({.name = recorded.filename().string(),
                                   .seed = seed,
                                   .limits = limits_of(file, path, preset),
                                   .digest = digest,
                                   .load = [recorded, bound = file.noise_bound, digest = std::move(digest)] {
                                     return load(recorded, bound, digest);
                                   }});
  }
  std::vector<CaseGroup> result;
  for (auto& [name, group] : groups) {
    group.name = name;
    group.provenance = fmt::format("files of the folder {}", (folder / "").parent_path().filename().string());
    result.push_back(std::move(group));
  }
  return result;
}

}  // namespace consimd::studies
