#include <consimd/studies/shard_merge.hpp>

#include <algorithm>
#include <set>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <consimd/studies/study_folder.hpp>
#include "small_study.hpp"
#include "temporary_folder.hpp"

namespace consimd::studies {
namespace {

using test::TemporaryFolder;
using test::text_of;
using test::write_text;

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr RunFacts kFacts{.isa = "scalar", .threads = 1};

const TrialTable& whole_study() {
  static const TrialTable table = [] {
    TrialTable whole(small_study());
    run_sweep(whole);
    return whole;
  }();
  return table;
}

LimitRecord limit_at(double sigma) {
  return {.sigma = sigma, .problems = kLimitProblems, .chance_support_mean = sigma};
}

/// Fills a folder with what `shard`, or none for all, has of the whole study's records: results and times are the same
/// in every division.
void write_part(const fs::path& path, std::optional<Shard> shard, const RunFacts& facts = kFacts,
                std::size_t most = 1000) {
  TrialTable table(small_study(), shard);
  StudyFolder folder(path, table, facts, false);
  std::vector<TrialRecord> records(whole_study().records().begin(), whole_study().records().end());
  std::ranges::reverse(records);  // trials end in any order
  for (const TrialRecord& record : records) {
    if (table.filled() == most) return;
    try {
      table.put(record);
    } catch (const std::invalid_argument&) {
      continue;  // of another shard
    }
    folder.append(record);
  }
  if (table.complete()) folder.finish(table, facts);
  for (const double sigma : limit_levels(small_study(), shard)) {
    if (table.complete()) folder.append(limit_at(sigma));
  }
}

std::vector<fs::path> write_shards(const fs::path& parent, std::uint32_t count) {
  std::vector<fs::path> folders;
  for (std::uint32_t index = 1; index <= count; ++index) {
    folders.push_back(parent / folder_name({index, count}));
    write_part(folders.back(), Shard{index, count});
  }
  return folders;
}

void merge_into(const fs::path& out, const std::vector<fs::path>& folders) {
  const MergedStudy merged = merge_shards(folders, false);
  write_study(out, merged.table, merged.limits, merged.summary, false);
}

template <typename... Texts>
void expect_refused(const std::vector<fs::path>& folders, bool need_limits, const Texts&... texts) {
  EXPECT_THAT([&] { (void)merge_shards(folders, need_limits); },
              ThrowsMessage<std::runtime_error>(AllOf(HasSubstr(texts)...)));
}

TEST(TrialTable, DealsProblemsOutEvenly) {
  SweepOptions options = small_study();
  options.solvers = {"tcf", "ransac"};
  for (const std::uint32_t count : {1u, 2u, 4u, 5u, 12u, 20u}) {
    std::size_t total = 0;
    std::size_t least = 1000;
    std::size_t most = 0;
    for (std::uint32_t index = 1; index <= count; ++index) {
      const TrialTable part(options, Shard{index, count});
      EXPECT_EQ(part.size() % 2, 0u) << "both solvers see a problem on one machine";
      total += part.size();
      least = std::min(least, part.size());
      most = std::max(most, part.size());
      // A cell's trials go around: no shard gets the costly cells.
      for (std::size_t cell = 0; cell < 4; ++cell) {
        std::uint32_t wanted = 0;
        for (std::uint32_t trial = 0; trial < options.trials; ++trial) wanted += part.wants(cell, trial);
        EXPECT_LE(wanted, (options.trials + count - 1) / count);
        EXPECT_GE(wanted, options.trials / count);
      }
    }
    EXPECT_EQ(total, TrialTable(options).size());
    EXPECT_LE(most - least, 2u);
  }
}

TEST(TrialTable, OfAShardRunsAndTakesItsTrialsOnly) {
  TrialTable part(small_study(), Shard{2, 5});
  run_sweep(part);
  EXPECT_TRUE(part.complete());
  EXPECT_EQ(part.size(), 3u);  // problems 1, 6 and 11 of 12
  std::vector<TrialRecord> records;
  part.for_each([&](const TrialRecord& record) { records.push_back(record); });
  const std::vector<TrialRecord> expected = timeless(whole_study());
  ASSERT_EQ(records.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    records[i].seconds = 0.0;
    EXPECT_EQ(records[i], expected[1 + 5 * i]);
  }
  EXPECT_THAT([&] { part.put(whole_study().records()[0]); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("is not of shard 2/5")));
}

TEST(ShardMerge, GivesTheFilesOfTheWholeStudy) {
  const TemporaryFolder folder;
  write_part(folder / "whole", std::nullopt);
  for (const std::uint32_t count : {1u, 3u, 5u, 20u}) {  // 20 are more than there are problems
    const fs::path parent = folder / std::to_string(count);
    std::vector<fs::path> shards = write_shards(parent, count);
    EXPECT_FALSE(fs::exists(shards[0] / "cells.csv"));
    std::ranges::reverse(shards);
    merge_into(parent, shards);
    for (const char* file : {"trials.csv", "cells.csv", "limits.csv", "summary.json"}) {
      EXPECT_EQ(text_of(parent / file), text_of(folder / "whole" / file)) << file << " of " << count;
    }
    merge_into(parent, shard_folders({parent}));  // again, over its own result
    EXPECT_EQ(text_of(parent / "trials.csv"), text_of(folder / "whole/trials.csv"));
  }
}

TEST(ShardMerge, ListsSeveralMachines) {
  const TemporaryFolder folder;
  write_part(folder / "1", Shard{1, 3}, {.isa = "avx2", .threads = 4});
  write_part(folder / "2", Shard{2, 3}, {.isa = "sse2", .threads = 8});
  write_part(folder / "3", Shard{3, 3}, {.isa = "avx2", .threads = 2});
  const auto summary = nlohmann::json::parse(merge_shards({folder / "3", folder / "1", folder / "2"}, false).summary);
  EXPECT_EQ(summary["isa"], (nlohmann::json{"avx2", "sse2"}));
  EXPECT_EQ(summary["threads"], (nlohmann::json{4, 8, 2}));
  EXPECT_TRUE(summary["machine"].is_object());
  EXPECT_FALSE(summary.contains("shard"));
}

TEST(ShardMerge, NamesMissingAndUnfinishedShards) {
  const TemporaryFolder folder;
  const std::vector<fs::path> shards = write_shards(folder / "s", 5);
  fs::remove_all(shards[1]);
  write_part(shards[1], Shard{2, 5}, kFacts, 2);
  const std::string before = text_of(shards[1] / "trials.csv");
  expect_refused({shards[0], shards[1], shards[3]}, false, "missing: 3/5, 5/5",
                 "unfinished: 2/5 in " + shards[1].string() + " (2 of 3 trials)");
  // A line that is being written, or was cut short, is no row and stays.
  write_text(shards[1] / "trials.csv", before.substr(0, before.size() - 5));
  expect_refused(shards, false, "(1 of 3 trials)");
  EXPECT_EQ(text_of(shards[1] / "trials.csv"), before.substr(0, before.size() - 5));
  fs::remove(shards[1] / "trials.csv");
  expect_refused(shards, false, "(0 of 3 trials)");
}

TEST(ShardMerge, RefusesWhatDoesNotBelongTogether) {
  const TemporaryFolder folder;
  std::vector<fs::path> shards = write_shards(folder / "s", 2);
  expect_refused({shards[0], shards[1], shards[0]}, false, "shard 1/2 is there twice");

  write_part(folder / "s/third", Shard{3, 3});
  expect_refused({shards[0], shards[1], folder / "s/third"}, false, "one of 3 shards", "one of 2", "one division");

  const std::string summary = text_of(shards[1] / "summary.json");
  const auto with = [&](const std::string& key, const nlohmann::json& value) {
    auto json = nlohmann::ordered_json::parse(summary);
    (key == "trials" ? json["options"][key] : json[key]) = value;
    write_text(shards[1] / "summary.json", json.dump());
  };
  with("trials", 7);
  expect_refused(shards, false, "is of another study than", "it has trials 7, not 3");
  with("version", "0.0.1");
  expect_refused(shards, false, "it has version 0.0.1");
  with("shard", "0/2");
  expect_refused(shards, false, (shards[1] / "summary.json").string(), "'0/2'");
  with("shard", 2);
  expect_refused(shards, false, "bad shard");
  write_text(shards[1] / "summary.json", "{}");
  expect_refused(shards, false, "not the summary of a study");
}

TEST(ShardMerge, WantsAllLimitsOrNone) {
  const TemporaryFolder folder;
  const std::vector<fs::path> shards = write_shards(folder / "s", 2);
  EXPECT_THAT(merge_shards(shards, true).limits, testing::ElementsAre(limit_at(0.1), limit_at(1.0)));
  fs::remove(shards[1] / "limits.csv");
  for (const bool need : {true, false}) expect_refused(shards, need, "run 2/2 with --map");
  fs::remove(shards[0] / "limits.csv");
  EXPECT_TRUE(merge_shards(shards, false).limits.empty());
  expect_refused(shards, true, "run 1/2, 2/2 with --map");
}

TEST(ShardMerge, FindsShardsInAFolder) {
  const TemporaryFolder folder;
  const std::vector<fs::path> shards = write_shards(folder / "s", 3);
  write_part(folder / "s", std::nullopt);
  EXPECT_EQ(shard_folders({folder / "s"}), shards);
  EXPECT_EQ(shard_folders({shards[2], shards[0]}), (std::vector{shards[2], shards[0]}));
  fs::create_directory(folder / "empty");
  for (const char* bad : {"empty", "nowhere"}) {
    EXPECT_THAT([&] { (void)shard_folders({folder / bad}); }, ThrowsMessage<std::runtime_error>(HasSubstr(bad)));
  }
}

TEST(ShardMerge, SparesAnotherStudy) {
  const TemporaryFolder folder;
  const MergedStudy merged = merge_shards(write_shards(folder / "s", 2), false);
  SweepOptions other = small_study();
  other.seed = 6;
  TrialTable table(other);
  { const StudyFolder opened(folder / "other", table, kFacts, false); }
  const auto write = [&](const char* name, bool fresh) {
    write_study(folder / name, merged.table, merged.limits, merged.summary, fresh);
  };
  EXPECT_THAT([&] { write("other", false); }, ThrowsMessage<std::runtime_error>(HasSubstr("it has seed 6, not 5")));
  EXPECT_THAT([&] { write("s/shard-1-of-2", false); },
              ThrowsMessage<std::runtime_error>(HasSubstr("it is shard 1/2, not the whole study")));
  write("other", true);
  EXPECT_EQ(text_of(folder / "other/summary.json"), merged.summary);
}

TEST(StudyFolder, BelongsToOneShardAndOneWriter) {
  const TemporaryFolder folder;
  write_part(folder / "s", Shard{1, 2});
  const auto open = [&](std::optional<Shard> shard) {
    TrialTable table(small_study(), shard);
    const StudyFolder opened(folder / "s", table, kFacts, false);
  };
  EXPECT_THAT(
      [&] {
        open(Shard{2, 2});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("it is shard 1/2, not shard 2/2")));
  EXPECT_THAT([&] { open(std::nullopt); },
              ThrowsMessage<std::runtime_error>(HasSubstr("it is shard 1/2, not the whole study")));
  TrialTable table(small_study(), Shard{1, 2});
  const StudyFolder writer(folder / "s", table, kFacts, false);
  EXPECT_THAT([&] { open(Shard{1, 2}); }, ThrowsMessage<std::runtime_error>(HasSubstr("another process is writing")));
}

}  // namespace
}  // namespace consimd::studies
