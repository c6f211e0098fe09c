#include <consimd/studies/study_folder.hpp>

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <nlohmann/json.hpp>

#include <consimd/studies/cell_summary.hpp>
#include "small_study.hpp"
#include "sweep/trial_sorting.hpp"
#include "temporary_folder.hpp"

namespace consimd::studies {
namespace {

using test::TemporaryFolder;
using test::text_of;
using test::write_text;

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr RunFacts kFacts{.isa = "scalar", .threads = 1};

/// Runs the small study in `path` until `most` trials are in its table; the table as it is then.
TrialTable run_in(const std::filesystem::path& path, std::size_t most, bool fresh = false) {
  TrialTable table(small_study());
  StudyFolder folder(path, table, kFacts, fresh);
  std::size_t trials = table.filled();
  const SweepControl control{.on_trial =
                                 [&](const TrialRecord& record) {
                                   folder.append(record);
                                   ++trials;
                                 },
                             .stop_requested = [&] { return trials >= most; }};
  tbb::task_arena(1).execute([&] { run_sweep(table, control); });
  if (table.complete()) folder.finish(table, kFacts);
  return table;
}

std::vector<std::string> lines(const std::filesystem::path& path) {
  std::istringstream text(text_of(path));
  std::vector<std::string> result;
  for (std::string line; std::getline(text, line);) result.push_back(line);
  return result;
}

TEST(StudyFolder, HoldsSortedTrialsCellsAndSummary) {
  const TemporaryFolder folder;
  const TrialTable table = run_in(folder / "study", 1000);
  const std::vector<std::string> trials = lines(folder / "study/trials.csv");
  ASSERT_EQ(trials.size(), 13u);
  EXPECT_EQ(trials[0], csv_header(kTrialColumns));
  for (std::size_t i = 0; i < table.size(); ++i) EXPECT_EQ(trials[i + 1] + "\n", to_csv_row(table.records()[i]));

  const std::vector<std::string> cells = lines(folder / "study/cells.csv");
  ASSERT_EQ(cells.size(), 5u);
  EXPECT_EQ(cells[0], csv_header(kCellColumns));
  EXPECT_TRUE(cells[4].starts_with("tcf,0.8,1,3,")) << cells[4];

  const auto summary = nlohmann::json::parse(text_of(folder / "study/summary.json"));
  EXPECT_EQ(summary["options"]["points"], 200);
  EXPECT_EQ(summary["trials_done"], 12);
  EXPECT_EQ(summary["complete"], true);
  EXPECT_EQ(summary["noise_bound"], "3 sigma");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / "study"), {}), 3);
}

TEST(StudyFolder, ResumedEqualsWhole) {
  const TemporaryFolder folder;
  const TrialTable whole = run_in(folder / "whole", 1000);
  EXPECT_EQ(run_in(folder / "resumed", 5).filled(), 5u);
  EXPECT_EQ(lines(folder / "resumed/trials.csv").size(), 6u);
  EXPECT_EQ(nlohmann::json::parse(text_of(folder / "resumed/summary.json"))["complete"], false);
  EXPECT_EQ(run_in(folder / "resumed", 8).filled(), 8u);
  const TrialTable resumed = run_in(folder / "resumed", 1000);
  EXPECT_TRUE(resumed.complete());
  EXPECT_EQ(timeless(resumed), timeless(whole));
  EXPECT_EQ(lines(folder / "resumed/trials.csv").size(), 13u);
}

TEST(StudyFolder, DropsTheLineThatACrashCutShort) {
  const TemporaryFolder folder;
  const TrialTable whole = run_in(folder / "whole", 1000);
  (void)run_in(folder / "cut", 5);
  const std::string text = text_of(folder / "cut/trials.csv");
  for (const std::size_t removed : {std::size_t{1}, std::size_t{30}}) {
    write_text(folder / "cut/trials.csv", text.substr(0, text.size() - removed));
    TrialTable table(small_study());
    const StudyFolder reopened(folder / "cut", table, kFacts, false);
    EXPECT_EQ(table.filled(), 4u);
  }
  EXPECT_EQ(timeless(run_in(folder / "cut", 1000)), timeless(whole));
  EXPECT_EQ(lines(folder / "cut/trials.csv").size(), 13u);
}

TEST(StudyFolder, SurvivesACrashBeforeTheFirstTrial) {
  const TemporaryFolder folder;
  (void)run_in(folder / "study", 0);
  write_text(folder / "study/trials.csv", "solver,outl");
  EXPECT_TRUE(run_in(folder / "study", 1000).complete());
  EXPECT_EQ(lines(folder / "study/trials.csv").size(), 13u);
}

TEST(StudyFolder, NamesTheDifferenceToAnotherStudy) {
  const TemporaryFolder folder;
  (void)run_in(folder / "study", 1000);
  const std::string before = text_of(folder / "study/trials.csv");
  const auto open_with = [&](auto change) {
    return [&folder, change] {
      SweepOptions options = small_study();
      change(options);
      TrialTable table(options);
      const StudyFolder reopened(folder / "study", table, kFacts, false);
    };
  };
  const auto names = [](const std::string& text) { return ThrowsMessage<std::runtime_error>(HasSubstr(text)); };
  EXPECT_THAT(open_with([](SweepOptions& o) { o.trials = 4; }), names("it has trials 3, not 4"));
  EXPECT_THAT(open_with([](SweepOptions& o) { o.points = {300}; }), names("it has points 200, not 300"));
  EXPECT_THAT(open_with([](SweepOptions& o) { o.seed = 1; }), names("it has seed 5, not 1"));
  EXPECT_THAT(open_with([](SweepOptions& o) { o.sigmas = {0.1, 2.0}; }), names("it has sigma 0.1,1.0, not 0.1,2.0"));
  EXPECT_THAT(open_with([](SweepOptions& o) { o.outlier_ratios = {0.5}; }), names("it has outliers 0.5,0.8, not 0.5"));
  EXPECT_EQ(text_of(folder / "study/trials.csv"), before);
}

TEST(StudyFolder, FreshStartsOver) {
  const TemporaryFolder folder;
  (void)run_in(folder / "study", 1000);
  EXPECT_EQ(run_in(folder / "study", 2, true).filled(), 2u);
  EXPECT_EQ(lines(folder / "study/trials.csv").size(), 3u);
  EXPECT_FALSE(std::filesystem::exists(folder / "study/cells.csv"));
}

TEST(StudyFolder, KeepsLimitsUntilAFreshStart) {
  const TemporaryFolder folder;
  const std::vector<LimitRecord> limits = {{.sigma = 1.0, .problems = kLimitProblems, .chance_support_mean = 4.5},
                                           {.sigma = 0.1, .problems = kLimitProblems, .chance_support_max = 3}};
  for (const LimitRecord& limit : limits) {
    TrialTable table(small_study());
    StudyFolder(folder / "study", table, kFacts, false).append(limit);
  }
  EXPECT_EQ(lines(folder / "study/limits.csv").front(), csv_header(kLimitColumns));
  TrialTable table(small_study());
  EXPECT_EQ(StudyFolder(folder / "study", table, kFacts, false).limits(), limits);
  EXPECT_TRUE(StudyFolder(folder / "study", table, kFacts, true).limits().empty());
  EXPECT_FALSE(std::filesystem::exists(folder / "study/limits.csv"));
}

TEST(StudyFolder, RefusesForeignLimits) {
  const TemporaryFolder folder;
  (void)run_in(folder / "study", 1000);
  const std::string before = text_of(folder / "study/summary.json");
  const std::string good = to_csv_row({.sigma = 1.0, .problems = kLimitProblems});
  for (const std::string& bad : {good, to_csv_row({.sigma = 2.0, .problems = kLimitProblems}),
                                 to_csv_row({.sigma = 0.1, .problems = kLimitProblems + 1})}) {
    std::string table_text = csv_header(kLimitColumns);
    table_text.append("\n").append(good).append(bad);
    write_text(folder / "study/limits.csv", table_text);
    TrialTable table(small_study());
    EXPECT_THAT([&] { const StudyFolder study(folder / "study", table, kFacts, false); },
                ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("limits.csv:3"), HasSubstr("not of this study"))));
  }
  EXPECT_EQ(text_of(folder / "study/summary.json"), before);
}

TEST(StudyFolder, RefusesTrialsThatWereChangedAndNamesTheLine) {
  const TemporaryFolder folder;
  (void)run_in(folder / "study", 5);
  const std::string good = text_of(folder / "study/trials.csv");
  for (const auto& [from, to] :
       {std::pair{",success,1,", ",success,7,"}, {",success,1,", ",splendid,1,"}, {",success,1,", ",success,1,nan,"}}) {
    std::string bad = good;
    bad.replace(bad.rfind(from), std::string_view(from).size(), to);
    write_text(folder / "study/trials.csv", bad);
    EXPECT_THAT([&] { (void)run_in(folder / "study", 1000); },
                ThrowsMessage<std::runtime_error>(HasSubstr("trials.csv:6: ")))
        << to;
    EXPECT_EQ(text_of(folder / "study/trials.csv"), bad);
  }
}

TEST(StudyFolder, DropsTheLimitThatACrashCutShort) {
  const TemporaryFolder folder;
  const LimitRecord limit{.sigma = 1.0, .problems = kLimitProblems, .chance_support_mean = 4.5};
  for (const std::string& left : {csv_header(kLimitColumns).substr(0, 4), csv_header(kLimitColumns) + "\n1,10,4."}) {
    (void)run_in(folder / "study", 0);
    write_text(folder / "study/limits.csv", left);
    TrialTable table(small_study());
    {
      StudyFolder opened(folder / "study", table, kFacts, false);
      EXPECT_TRUE(opened.limits().empty());
      opened.append(limit);
      EXPECT_TRUE(opened.has_limit(1.0));
      EXPECT_FALSE(opened.has_limit(0.1));
    }
    EXPECT_EQ(text_of(folder / "study/limits.csv"), csv_header(kLimitColumns) + "\n" + to_csv_row(limit));
  }
}

TEST(StudyFolder, ThatWasBeingWrittenCanBeWrittenAgain) {
  const TemporaryFolder folder;
  const TrialTable whole = run_in(folder / "whole", 1000);
  const std::string summary = text_of(folder / "whole/summary.json");
  // Stopped after the first table.
  std::filesystem::create_directories(folder / "study/cells.csv/in the way");
  EXPECT_THROW(write_study(folder / "study", whole, {}, summary, false), std::runtime_error);
  EXPECT_EQ(nlohmann::json::parse(text_of(folder / "study/summary.json"))["complete"], false);
  std::filesystem::remove_all(folder / "study/cells.csv");
  write_study(folder / "study", whole, {}, summary, false);
  for (const char* const name : {"trials.csv", "cells.csv", "summary.json"}) {
    EXPECT_EQ(text_of(folder / ("study/" + std::string(name))), text_of(folder / ("whole/" + std::string(name))))
        << name;
  }
}

TEST(StudyFolder, NeedsNoRecordsInMemory) {
  const TemporaryFolder folder;
  const TrialTable whole = run_in(folder / "whole", 1000);
  TrialTable marks(small_study(), {}, TrialTable::Keep::marks);
  EXPECT_TRUE(marks.records().empty());
  StudyFolder files(folder / "study", marks, kFacts, false);
  for (std::size_t i = whole.size(); i-- > 0;) {  // trials end in any order
    files.append(whole.records()[i]);
    marks.put(whole.records()[i]);
  }
  EXPECT_TRUE(marks.complete());
  const StudySummary summary = files.finish(marks, kFacts);
  EXPECT_EQ(summary.cells().size(), 4u);
  EXPECT_EQ(summary.ratios().size(), 2u);
  for (const char* const name : {"trials.csv", "cells.csv", "summary.json"}) {
    EXPECT_EQ(text_of(folder / ("study/" + std::string(name))), text_of(folder / ("whole/" + std::string(name))))
        << name;
  }
}

TEST(TrialSorting, IsTheSameInPartsThatMemoryHolds) {
  const TemporaryFolder folder;
  const TrialTable whole = run_in(folder / "study", 1000);
  std::string shuffled = csv_header(kTrialColumns) + "\n";
  for (const std::size_t i : std::vector<std::size_t>{7, 3, 11, 0, 5, 1, 10, 2, 9, 4, 8, 6})
    shuffled += to_csv_row(whole.records()[i]);
  write_text(folder / "trials.csv", shuffled);
  for (const std::size_t rows : {1U, 3U, 5U, 100U}) {
    std::vector<TrialRecord> sorted;
    for_each_sorted(
        folder / "trials.csv", whole, [&](const TrialRecord& record) { sorted.push_back(record); }, rows);
    EXPECT_TRUE(std::ranges::equal(sorted, whole.records())) << rows;
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / ""), {}), 2);  // the study and the file
}

TEST(StudyFolder, RefusesForeignFiles) {
  const TemporaryFolder folder;
  const auto open = [&] {
    TrialTable table(small_study());
    const StudyFolder opened(folder / "study", table, kFacts, false);
  };
  std::filesystem::create_directory(folder / "study");
  write_text(folder / "study/trials.csv", "my,own,table\n");
  EXPECT_THROW(open(), std::runtime_error);
  write_text(folder / "study/summary.json", "{}");
  EXPECT_THROW(open(), std::runtime_error);
  write_text(folder / "study/summary.json", "no json");
  EXPECT_THROW(open(), std::runtime_error);
  write_text(folder / "study/summary.json", summary_json(TrialTable(small_study()), kFacts));
  EXPECT_THROW(open(), std::runtime_error);
  EXPECT_EQ(text_of(folder / "study/trials.csv"), "my,own,table\n");
}

}  // namespace
}  // namespace consimd::studies
