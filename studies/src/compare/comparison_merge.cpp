#include <consimd/studies/comparison_merge.hpp>

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/synth/text_file.hpp>

#include <consimd/studies/shard.hpp>
#include "compare/comparison_summary.hpp"
#include "files/csv_file.hpp"
#include "provenance/run_json.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
using namespace detail;
namespace {

struct ShardFolder {
  fs::path path;
  std::string text;  ///< of its comparison.json
  Shard shard;
};

/// Passes on a complaint about a comparison.json with the name of the file.
template <typename Read>
auto with_name(const fs::path& folder, const Read& read) {
  try {
    return read();
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", (folder / kComparisonFile).string(), error.what()));
  }
}

std::optional<Shard> shard_in(const fs::path& folder) {
  if (std::error_code ignored; !fs::exists(folder / kComparisonFile, ignored)) return std::nullopt;
  return with_name(folder, [&] { return comparison_shard(synth::read_text(folder / kComparisonFile)); });
}

/// The first shard comes first.
std::vector<ShardFolder> open_shards(const std::vector<fs::path>& folders) {
  std::vector<ShardFolder> shards;
  for (const fs::path& folder : folders) {
    const std::optional<Shard> shard = shard_in(folder);
    if (!shard) throw std::runtime_error(fmt::format("{}: not a shard of a comparison", folder.string()));
    shards.push_back({folder, synth::read_text(folder / kComparisonFile), *shard});
  }
  if (shards.empty()) throw std::runtime_error("no shards to merge");
  std::ranges::sort(shards, {}, [](const ShardFolder& s) { return s.shard.index; });
  return shards;
}

/// Those of one division of one comparison, each once.
void require_one_comparison(const std::vector<ShardFolder>& shards, const ShardedComparison& whole) {
  const ShardFolder& first = shards.front();
  for (const ShardFolder& other : shards) {
    if (other.shard.count != first.shard.count) {
      throw std::runtime_error(fmt::format("{} is one of {} shards, {} one of {}: name the folders of one division",
                                           other.path.string(), other.shard.count, first.path.string(),
                                           first.shard.count));
    }
    const std::string what = with_name(other.path, [&] {
      const Comparison part(whole.groups, whole.runs, whole.tables.outside, other.shard);
      return comparison_difference(other.text, whole.summary.at("options"), part);
    });
    if (what.empty()) continue;
    if (&other == &first) {
      throw std::runtime_error(fmt::format("{} is of another version: {}", first.path.string(), what));
    }
    throw std::runtime_error(
        fmt::format("{} is of another comparison than {}: {}", other.path.string(), first.path.string(), what));
  }
  const auto twice = std::ranges::adjacent_find(shards, {}, [](const ShardFolder& s) { return s.shard.index; });
  if (twice != shards.end()) {
    throw std::runtime_error(fmt::format("shard {} is there twice: {} and {}", to_string(twice->shard),
                                         twice->path.string(), std::next(twice)->path.string()));
  }
}

/// The rows of runs.csv that are whole: a process may be writing.
void take_runs(const fs::path& folder, Comparison& comparison) {
  const fs::path path = folder / kRunsFile;
  const std::string text = synth::read_text(path);
  for_each_row(path, std::string_view(text).substr(0, text.rfind('\n') + 1), csv_header(kRunColumns),
               [&](std::string_view line) { comparison.put(parse_run_row(line)); });
}

Comparison merged_runs(const std::vector<ShardFolder>& shards, const ShardedComparison& whole) {
  Comparison merged(whole.groups, whole.runs, whole.tables.outside);
  constexpr std::size_t kMostNamed = 20;
  std::size_t absent = 0;
  std::vector<std::string> missing, unfinished;
  for (std::uint32_t index = 1; index <= shards.front().shard.count; ++index) {
    const Shard shard{index, shards.front().shard.count};
    const auto found = std::ranges::find(shards, shard, &ShardFolder::shard);
    if (found == shards.end()) {
      if (++absent <= kMostNamed) missing.push_back(to_string(shard));
      continue;
    }
    Comparison part(whole.groups, whole.runs, whole.tables.outside, shard);
    take_runs(found->path, part);
    if (!part.complete()) {
      unfinished.push_back(
          fmt::format("{} in {} ({} of {} runs)", to_string(shard), found->path.string(), part.filled(), part.size()));
    }
    for (RunRecord& record : part.done()) merged.put(std::move(record));
  }
  if (missing.empty() && unfinished.empty()) return merged;
  if (absent > kMostNamed) missing.push_back(fmt::format("and {} more", absent - kMostNamed));
  std::vector<std::string> parts;
  if (!missing.empty()) parts.push_back(fmt::format("missing: {}", fmt::join(missing, ", ")));
  if (!unfinished.empty()) parts.push_back(fmt::format("unfinished: {}", fmt::join(unfinished, ", ")));
  throw std::runtime_error(
      fmt::format("not all shards are done: {}; 'consimd compare' with the options of the comparison and --shard runs "
                  "or resumes them",
                  fmt::join(parts, "; ")));
}

/// What the shards ran on: where they differ, all values in the order of the shards.
Json merged_environment(const std::vector<ShardFolder>& shards) {
  Json merged = environment_json({}, 0);
  for (auto& [key, value] : merged.items()) {
    Json values = Json::array();
    for (const ShardFolder& shard : shards) {
      Json of_shard = parse_json(shard.text).value(key, Json());
      if (std::ranges::find(values, of_shard) == values.end()) values.push_back(std::move(of_shard));
    }
    value = values.size() == 1 ? values[0] : values;
  }
  return merged;
}

}  // namespace

std::vector<fs::path> comparison_shards(const std::vector<fs::path>& folders) {
  std::vector<fs::path> found;
  for (const fs::path& folder : folders) {
    if (shard_in(folder)) {
      found.push_back(folder);
      continue;
    }
    std::error_code ignored;
    std::vector<fs::path> inside;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.is_directory(ignored) && shard_in(entry.path())) inside.push_back(entry.path());
    }
    std::ranges::sort(inside);  // the order of a directory is not the same everywhere
    std::ranges::move(inside, std::back_inserter(found));
  }
  return found;
}

MergedComparison merge_comparisons(const std::vector<fs::path>& folders) {
  const std::vector<ShardFolder> shards = open_shards(folders);
  const ShardedComparison whole =
      with_name(shards.front().path, [&] { return sharded_comparison(shards.front().text); });
  require_one_comparison(shards, whole);
  Comparison comparison = merged_runs(shards, whole);
  std::string summary =
      summary_text(comparison_json(merged_environment(shards), whole.summary.at("options"), comparison));
  return {std::move(comparison), whole.tables, std::move(summary)};
}

}  // namespace consimd::studies
