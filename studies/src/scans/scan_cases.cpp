#include <consimd/studies/scan_cases.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <oneapi/tbb/parallel_for.h>

#include <consimd/features/cloud_files.hpp>
#include <consimd/features/register_clouds.hpp>
#include <consimd/synth/problem_files.hpp>
#include <consimd/synth/text_file.hpp>

#include <consimd/studies/build_info.hpp>
#include <consimd/studies/case_folder.hpp>
#include <consimd/studies/replace_file.hpp>
#include "files/digest.hpp"
#include "files/json_text.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

constexpr const char* kCorrespondences = "correspondences.txt";
constexpr const char* kPose = "pose.txt";
constexpr const char* kCase = "case.json";
constexpr const char* kDigest = "digest";

using Texts = std::vector<std::pair<std::string, std::string>>;

template <typename Value>
std::string text_of(const std::optional<Value>& value, std::string_view without) {
  return value ? fmt::format("{}", *value) : std::string(without);
}

std::string place(const std::optional<std::array<double, 3>>& viewpoint) {
  return viewpoint ? fmt::format("{}", fmt::join(*viewpoint, " ")) : "none";
}

Texts front_end_texts(const ScanOptions& options) {
  // A member that is added is to be added here.
  const auto& [voxel, normal_radius, descriptor_radius, keypoints, farthest, iss, iss_radius, iss_suppression_radius,
               matches, seed, source_viewpoint, target_viewpoint] = options.front_end;
  const auto& [best, mutual, ratio, most_distances] = matches;
  return {{"voxel", text_of(voxel, "chosen")},
          {"normal_radius", fmt::format("{}", normal_radius)},
          {"descriptor_radius", fmt::format("{}", descriptor_radius)},
          {"keypoints", text_of(keypoints, "all")},
          {"farthest", farthest ? "yes" : "no"},
          {"iss", iss ? fmt::format("{} {}", iss_radius, iss_suppression_radius) : "no"},
          {"matches", fmt::format("{} {}", mutual ? "mutual" : "nearest", best)},
          {"ratio", fmt::format("{}", ratio)},
          {"most_distances", fmt::format("{}", most_distances)},
          {"viewpoints", fmt::format("{}; {}", place(source_viewpoint), place(target_viewpoint))},
          {"missing", text_of(options.missing, "none")},
          {"noise_bound", text_of(options.noise_bound, "from the resolution")}};
}

std::string file_name_of(const std::string& path) { return (fs::path(path) / "").parent_path().filename().string(); }

/// A path that any system takes.
std::string folder_name_of(std::string_view group, std::string_view name) {
  std::string folder = fmt::format("{}_{}", group, name);
  for (char& c : folder) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '_';
    if (!plain) c = '_';
  }
  return folder;
}

/// What the cases of one data set share.
struct FrontEnd {
  features::CloudMatchingOptions matching;
  std::optional<double> missing;
  std::optional<double> noise_bound;

  [[nodiscard]] CaseData data_of(const features::CloudMatches& matches, const RigidTransform& truth) const {
    const auto flat = [](const std::vector<std::array<double, 3>>& points) {
      std::vector<double> numbers;
      numbers.reserve(3 * points.size());
      for (const auto& p : points) numbers.insert(numbers.end(), p.begin(), p.end());
      return numbers;
    };
    const double bound = noise_bound.value_or(matches.noise_bound);
    return {synth::labelled_problem(flat(matches.source_points), flat(matches.target_points), truth, bound), bound};
  }
};

/// Where the correspondences of a pair are kept, and as what.
struct CachedCase {
  fs::path folder;  ///< empty: nowhere
  std::string digest;
  std::string dataset, sequence;
  std::optional<PoseLimits> limits;
};

/// Those of this digest; none where there are none, or where they are damaged.
std::optional<CaseData> read_cached(const CachedCase& cached, const RigidTransform& truth) {
  if (std::error_code ignored; cached.folder.empty() || !fs::exists(cached.folder / kCase, ignored)) return {};
  try {
    const Json json = parse_json(synth::read_text(cached.folder / kCase));
    if (!json.is_object() || json.value(kDigest, Json()) != cached.digest) return {};
    const double bound = read_case_file(cached.folder / kCase).noise_bound;
    synth::Problem there = synth::read_problem(cached.folder / kCorrespondences, cached.folder / kPose, bound);
    if (json.value("correspondences", Json()) != there.size()) return {};
    return CaseData{synth::labelled_problem(std::move(there.source), std::move(there.target), truth, bound), bound};
  } catch (const std::exception&) {
    return {};  // made anew
  }
}

/// The last file says that the others are whole.
void write_cached(const CachedCase& cached, const CaseData& data) {
  constexpr std::size_t kFewest = 3;  // that a file of correspondences may have
  if (cached.folder.empty() || data.problem.size() < kFewest) return;
  std::error_code error;
  fs::remove(cached.folder / kCase, error);
  synth::write_problem(data.problem, cached.folder);
  Json json{{"noise_bound", data.noise_bound}};
  if (!cached.dataset.empty()) json["dataset"] = cached.dataset;
  if (!cached.sequence.empty()) json["sequence"] = cached.sequence;
  if (cached.limits) {
    json["max_rotation_error_deg"] = cached.limits->rotation_deg;
    json["max_translation_error_m"] = cached.limits->translation;
  }
  json["correspondences"] = data.problem.size();
  json[kDigest] = cached.digest;
  replace_file(cached.folder / kCase, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

Cloud read_scan(const fs::path& path, const std::optional<double>& missing) {
  Cloud cloud = features::read_cloud(path, missing);
  if (cloud.empty()) throw std::runtime_error(fmt::format("{}: holds no points", path.string()));
  return cloud;
}

/// Reads scans in parallel. Digests of their bytes come out in the order of the paths; those that `parse` names are
/// read as clouds too. Of several faults the first one's is thrown.
std::vector<std::string> checked_scans(const std::vector<fs::path>& paths, const std::set<fs::path>& parse,
                                       const std::optional<double>& missing,
                                       const std::function<void(std::size_t, std::size_t)>& on_scan) {
  std::vector<std::string> digests(paths.size());
  std::vector<std::exception_ptr> faults(paths.size());
  std::mutex telling;
  std::size_t done = 0;
  tbb::parallel_for(std::size_t{0}, paths.size(), [&](std::size_t k) {
    try {
      Digest digest;
      digest.add(synth::read_text(paths[k]));
      digests[k] = digest.text();
      if (parse.contains(paths[k])) static_cast<void>(read_scan(paths[k], missing));
    } catch (...) {
      faults[k] = std::current_exception();
    }
    if (!on_scan || faults[k]) return;
    const std::lock_guard lock(telling);
    on_scan(++done, paths.size());
  });
  for (const std::exception_ptr& fault : faults) {
    if (fault) std::rethrow_exception(fault);
  }
  return digests;
}

/// Passes on a complaint about clouds or options with the names of the files.
template <typename Work>
auto with_names(const ScanPair& pair, const Work& work) {
  try {
    return work();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{} and {}: {}", pair.source.string(), pair.target.string(), error.what()));
  }
}

ScanRun run_pipeline(const FrontEnd& front_end, const ScanPair& pair, std::string_view solver, std::uint64_t seed) {
  const Cloud source = read_scan(pair.source, front_end.missing), target = read_scan(pair.target, front_end.missing);
  features::CloudMatchingOptions matching = front_end.matching;
  matching.seed = seed;
  const auto start = std::chrono::steady_clock::now();
  features::CloudRegistration found = with_names(pair, [&] {
    return features::register_clouds(
        source, target,
        {.matching = matching, .noise_bound = front_end.noise_bound, .solver = std::string(solver), .seed = seed});
  });
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  ScanRun run{outcome_of(std::move(found.registration)), front_end.data_of(found.matches, pair.T_target_source)};
  run.outcome.seconds = seconds.count();
  return run;
}

std::optional<PoseLimits> limits_of(const ScanGroup& group, const ScanPair& pair, std::string_view preset) {
  if (preset == kDisplacementPreset) return std::nullopt;
  if (const auto limits = preset_limits(preset, group.dataset)) return limits;
  return pair.limits;
}

/// The identity of a pair's correspondences.
std::string digest_of(const ScanPair& pair, std::string_view source, std::string_view target, const Texts& texts,
                      std::uint64_t seed) {
  Digest digest;
  digest.add(source);
  digest.add(target);
  const Eigen::Matrix<double, 3, 4> pose = pair.T_target_source.affine();
  digest.add(fmt::format("{}", fmt::join(pose.data(), pose.data() + pose.size(), " ")));
  if (pair.information) digest.add(fmt::format("{}", fmt::join(*pair.information, " ")));
  for (const auto& [name, value] : texts) digest.add(fmt::format("{}={}", name, value));
  digest.add(fmt::format("seed={}", seed));
  digest.add(build_info().version);  // whose front end it was
  return digest.text();
}

Case case_of(const std::shared_ptr<const FrontEnd>& front_end, const ScanPair& pair, const CachedCase& cached) {
  return {
      .name = pair.name,
      .limits = cached.limits,
      .displacement =
          pair.information ? std::optional(DisplacementLimit{*pair.information, kDisplacementLimit}) : std::nullopt,
      .digest = cached.digest,
      .distance = pair.T_target_source.translation().norm(),
      .load =
          [front_end, pair, cached] {
            if (std::optional<CaseData> there = read_cached(cached, pair.T_target_source)) return *std::move(there);
            const Cloud source = read_scan(pair.source, front_end->missing);
            const Cloud target = read_scan(pair.target, front_end->missing);
            const features::CloudMatches matches =
                with_names(pair, [&] { return features::match_clouds(source, target, front_end->matching); });
            CaseData data = front_end->data_of(matches, pair.T_target_source);
            write_cached(cached, data);
            return data;
          },
      .register_scans = [front_end, pair](std::string_view solver,
                                          std::uint64_t seed) { return run_pipeline(*front_end, pair, solver, seed); }};
}

void validate(const ScanOptions& options, std::string_view preset) {
  const auto require_length = [](std::string_view name, const std::optional<double>& length) {
    if (!length || (std::isfinite(*length) && *length > 0.0)) return;
    throw std::invalid_argument(fmt::format("{}: expected a length above 0, got {}", name, *length));
  };
  require_length("voxel", options.front_end.voxel);
  require_length("noise bound", options.noise_bound);
  require_known_preset(preset);
  // Throws where the preset needs a gt.info.
  if (preset == kDisplacementPreset && options.layout.layout != "3dmatch") static_cast<void>(preset_limits(preset, ""));
}

}  // namespace

Texts scan_option_texts(const ScanOptions& options) {
  const LayoutOptions& layout = options.layout;
  Texts texts{{"scans", file_name_of(layout.folder)},
              {"layout", layout.layout},
              {"sequences", layout.sequences.empty() ? "all" : fmt::format("{}", fmt::join(layout.sequences, ","))},
              {"pairs", text_of(layout.pairs, "the layout's")},
              {"distance", fmt::format("{}", layout.distance)},
              {"pair_list", file_name_of(layout.pair_list)},
              {"ground_truth", file_name_of(layout.ground_truth)},
              {"overlap", layout.overlap ? fmt::format("{}:{}", (*layout.overlap)[0], (*layout.overlap)[1]) : "any"},
              {"skip_consecutive", layout.skip_consecutive ? "yes" : "no"}};
  std::ranges::move(front_end_texts(options), std::back_inserter(texts));
  return texts;
}

ScanGroups scan_groups(const ScanOptions& options, std::string_view preset,
                       const std::function<void(std::size_t, std::size_t)>& on_scan) {
  validate(options, preset);
  const ScanList list = read_scan_list(options.layout, preset == kDisplacementPreset);
  const auto front_end = std::make_shared<FrontEnd>(FrontEnd{options.front_end, options.missing, options.noise_bound});
  front_end->matching.seed = options.layout.seed;
  const auto cache_folder = [&](const ScanGroup& group, const ScanPair& pair) {
    return options.cache.empty() ? fs::path() : options.cache / folder_name_of(group.name, pair.name);
  };

  std::map<fs::path, std::string> digests;
  std::set<fs::path> parse;
  for (const ScanGroup& group : list.groups) {
    for (const ScanPair& pair : group.pairs) {
      static_cast<void>(limits_of(group, pair, preset));  // before the scans are read
      const fs::path cached = cache_folder(group, pair);
      std::error_code ignored;
      const bool made = !cached.empty() && fs::exists(cached / kCase, ignored);
      for (const fs::path& path : {pair.source, pair.target}) {
        digests.try_emplace(path);
        if (!made) parse.insert(path);
      }
    }
  }
  std::vector<fs::path> paths;
  paths.reserve(digests.size());
  for (const auto& [path, digest] : digests) paths.push_back(path);
  std::vector<std::string> found = checked_scans(paths, parse, options.missing, on_scan);
  for (std::size_t k = 0; k < paths.size(); ++k) digests[paths[k]] = std::move(found[k]);

  const Texts texts = front_end_texts(options);
  ScanGroups result{.groups = {}, .notes = list.notes};
  for (const ScanGroup& group : list.groups) {
    CaseGroup cases{.name = group.name, .provenance = group.provenance};
    for (const ScanPair& pair : group.pairs) {
      const CachedCase cached{
          .folder = cache_folder(group, pair),
          .digest = digest_of(pair, digests[pair.source], digests[pair.target], texts, options.layout.seed),
          .dataset = group.dataset,
          .sequence = group.sequence,
          .limits = limits_of(group, pair, preset)};
      cases.cases.push_back(case_of(front_end, pair, cached));
      cases.cases.back().seed = options.layout.seed;
    }
    result.groups.push_back(std::move(cases));
  }
  return result;
}

}  // namespace consimd::studies
