#include <consimd/studies/shard_merge.hpp>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/synth/text_file.hpp>

#include <consimd/studies/shard.hpp>
#include <consimd/studies/study_folder.hpp>
#include <consimd/studies/study_summary.hpp>
#include "files/csv_file.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

struct ShardFolder {
  fs::path path;
  std::string summary;
  Shard shard;
};

/// Passes on a complaint about a summary with the name of the file.
template <typename Read>
auto read_summary(const fs::path& folder, const Read& read) {
  try {
    return read(synth::read_text(folder / kSummaryFile));
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", (folder / kSummaryFile).string(), error.what()));
  }
}

bool is_shard(const fs::path& folder) {
  return fs::exists(folder / kSummaryFile) && read_summary(folder, shard_of).has_value();
}

ShardFolder open_shard(const fs::path& folder) {
  return read_summary(folder, [&](std::string text) {
    const std::optional<Shard> shard = shard_of(text);
    if (!shard) throw std::invalid_argument("not that of a shard");
    return ShardFolder{folder, std::move(text), *shard};
  });
}

/// The first shard comes first.
std::vector<ShardFolder> open_shards(const std::vector<fs::path>& folders) {
  std::vector<ShardFolder> shards;
  shards.reserve(folders.size());
  for (const fs::path& folder : folders) shards.push_back(open_shard(folder));
  std::ranges::sort(shards, {}, [](const ShardFolder& s) { return s.shard.index; });
  return shards;
}

void require_one_study(const std::vector<ShardFolder>& shards, const SweepOptions& options) {
  const ShardFolder& first = shards.front();
  for (const ShardFolder& other : shards) {
    if (other.shard.count != first.shard.count) {
      throw std::runtime_error(fmt::format("{} is one of {} shards, {} one of {}: name the folders of one division",
                                           other.path.string(), other.shard.count, first.path.string(),
                                           first.shard.count));
    }
    const std::string what =
        read_summary(other.path, [&](std::string_view text) { return difference_but_shard(text, options); });
    if (what.empty()) continue;
    if (&other == &first)
      throw std::runtime_error(fmt::format("{} is of another version: {}", first.path.string(), what));
    throw std::runtime_error(
        fmt::format("{} is of another study than {}: {}", other.path.string(), first.path.string(), what));
  }
  const auto twice = std::ranges::adjacent_find(shards, {}, [](const ShardFolder& s) { return s.shard.index; });
  if (twice != shards.end()) {
    throw std::runtime_error(fmt::format("shard {} is there twice: {} and {}", to_string(twice->shard),
                                         twice->path.string(), std::next(twice)->path.string()));
  }
}

/// The rows of a table that a process may be writing.
void for_each_row_so_far(const fs::path& path, std::string_view columns,
                         const std::function<void(std::string_view)>& take) {
  const std::string text = synth::read_text(path);
  for_each_row(path, std::string_view(text).substr(0, text.rfind('\n') + 1), columns, take);
}

/// Calls `take` with the trials of a shard.
void for_each_trial(const ShardFolder& shard, bool wide, const std::function<void(TrialRecord)>& take) {
  if (!fs::exists(shard.path / kTrialsFile)) return;
  for_each_row_so_far(shard.path / kTrialsFile, trial_header(wide),
                      [&](std::string_view line) { take(parse_trial_row(line, wide)); });
}

/// "missing: 2/4, 3/4; unfinished: 1/4 in DIR (12 of 75 trials)"
std::string gaps(const std::vector<ShardFolder>& shards, const std::vector<std::string>& unfinished) {
  constexpr std::size_t kMostNamed = 20;
  std::vector<std::string> missing;
  const std::uint32_t count = shards.front().shard.count;
  std::size_t absent = 0;
  for (std::uint32_t index = 1; index <= count; ++index) {
    const Shard shard{index, count};
    if (std::ranges::find(shards, shard, &ShardFolder::shard) != shards.end()) continue;
    if (++absent <= kMostNamed) missing.push_back(to_string(shard));
  }
  if (absent > kMostNamed) missing.push_back(fmt::format("and {} more", absent - kMostNamed));
  std::vector<std::string> parts;
  if (!missing.empty()) parts.push_back(fmt::format("missing: {}", fmt::join(missing, ", ")));
  if (!unfinished.empty()) parts.push_back(fmt::format("unfinished: {}", fmt::join(unfinished, ", ")));
  return fmt::format("{}", fmt::join(parts, "; "));
}

TrialTable merge_trials(const std::vector<ShardFolder>& shards, const SweepOptions& options) {
  std::vector<std::string> unfinished;
  for (const ShardFolder& shard : shards) {
    TrialTable part(options, shard.shard, TrialTable::Keep::marks);
    for_each_trial(shard, part.wide(), [&](TrialRecord record) { part.put(std::move(record)); });
    if (!part.complete()) {
      unfinished.push_back(fmt::format("{} in {} ({} of {} trials)", to_string(shard.shard), shard.path.string(),
                                       part.filled(), part.size()));
    }
  }
  if (const std::string what = gaps(shards, unfinished); !what.empty()) {
    throw std::runtime_error(
        fmt::format("not all shards are done: {}; 'consimd sweep' with the options of the study "
                    "and --shard runs or resumes them",
                    what));
  }
  TrialTable merged(options);
  for (const ShardFolder& shard : shards) {
    for_each_trial(shard, merged.wide(), [&](TrialRecord record) { merged.put(std::move(record)); });
  }
  return merged;
}

std::vector<LimitRecord> merge_limits(const std::vector<ShardFolder>& shards, const SweepOptions& options, bool need) {
  std::vector<LimitRecord> found;
  std::vector<std::string> without;
  for (const ShardFolder& shard : shards) {
    const std::vector<double> of_shard = limit_levels(options, shard.shard);
    std::set<double> levels(of_shard.begin(), of_shard.end());
    if (const fs::path path = shard.path / kLimitsFile; fs::exists(path)) {
      for_each_row_so_far(path, csv_header(kLimitColumns), [&](std::string_view line) {
        const LimitRecord limit = parse_limit_row(line);
        if (limit.problems != kLimitProblems || levels.erase(limit.sigma) != 1) {
          throw std::invalid_argument(fmt::format("noise level {} with {} problems is not of shard {}", limit.sigma,
                                                  limit.problems, to_string(shard.shard)));
        }
        found.push_back(limit);
      });
    }
    if (!levels.empty()) without.push_back(to_string(shard.shard));
  }
  if ((need || !found.empty()) && !without.empty()) {
    throw std::runtime_error(fmt::format("the limits of {} are not all there: run {} with --map",
                                         without.size() == 1 ? "a shard" : "some shards", fmt::join(without, ", ")));
  }
  std::map<double, std::size_t> places;
  for (const double sigma : options.sigmas) places.emplace(sigma, places.size());
  std::ranges::sort(found, {}, [&](const LimitRecord& limit) { return places.at(limit.sigma); });
  return found;
}

}  // namespace

std::vector<fs::path> shard_folders(const std::vector<fs::path>& folders) {
  std::vector<fs::path> found;
  for (const fs::path& folder : folders) {
    if (!fs::is_directory(folder)) throw std::runtime_error(fmt::format("{}: no such folder", folder.string()));
    if (is_shard(folder)) {
      found.push_back(folder);
      continue;
    }
    std::vector<fs::path> inside;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (entry.is_directory() && is_shard(entry.path())) inside.push_back(entry.path());
    }
    if (inside.empty()) {
      throw std::runtime_error(
          fmt::format("{}: neither a shard of a study nor a folder of shards; 'consimd sweep --shard K/N' makes them",
                      folder.string()));
    }
    std::ranges::sort(inside);  // the order of a directory is not the same everywhere
    std::ranges::move(inside, std::back_inserter(found));
  }
  return found;
}

MergedStudy merge_shards(const std::vector<fs::path>& folders, bool need_limits) {
  const std::vector<ShardFolder> shards = open_shards(folders);
  if (shards.empty()) throw std::runtime_error("no shards to merge");
  const SweepOptions options = read_summary(shards.front().path, options_of);
  require_one_study(shards, options);
  TrialTable table = merge_trials(shards, options);
  std::vector<LimitRecord> limits = merge_limits(shards, options, need_limits);
  std::vector<std::string> summaries;
  summaries.reserve(shards.size());
  for (const ShardFolder& shard : shards) summaries.push_back(shard.summary);
  std::string summary = merged_summary_json(table, summaries);
  return {std::move(table), std::move(limits), std::move(summary)};
}

}  // namespace consimd::studies
