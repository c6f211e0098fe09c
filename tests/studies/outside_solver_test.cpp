// Solvers of others as functions: in sweeps and comparisons they are what consimd's own are.
#include <consimd/studies/outside_solver.hpp>

#include <atomic>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <consimd/solvers/solver.hpp>
#include <consimd/studies/compare_options.hpp>
#include <consimd/studies/comparison_folder.hpp>
#include <consimd/studies/shard_merge.hpp>
#include <consimd/studies/study_folder.hpp>
#include <consimd/synth/noise_study.hpp>

#include "outside/reply_text.hpp"
#include "small_study.hpp"
#include "temporary_folder.hpp"

namespace consimd::studies {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// consimd's default solver as somebody else's.
OutsideReply tcf(const OutsideProblem& problem) {
  return register_by_name("tcf", problem.correspondences, {.noise_bound = problem.noise_bound, .seed = problem.seed});
}

SweepOptions study_of(OutsideSolver solver, std::vector<std::string> solvers = {"mine", "tcf"}) {
  SweepOptions options = small_study();
  options.solvers = std::move(solvers);
  options.outside = {std::move(solver)};
  return options;
}

/// The records of a study with `renamed` in place of their solver, and without times.
std::vector<TrialRecord> records_of(SweepOptions options, const std::string& renamed) {
  TrialTable table(std::move(options));
  run_sweep(table);
  std::vector<TrialRecord> records = timeless(table);
  for (TrialRecord& record : records) record.solver = renamed;
  return records;
}

/// What ends a study of a solver that answers so.
template <typename Answer>
void run_with(Answer answer) {
  TrialTable table(study_of({.name = "mine", .solve = answer}, {"mine"}));
  run_sweep(table);
}

TEST(OutsideSolver, GivesTheRecordsOfTheSameSolver) {
  for (const Filter filter : {Filter::none, Filter::tcf}) {
    SweepOptions options = study_of({.name = "mine", .solve = tcf}, {"mine"});
    SweepOptions own = small_study();
    options.filter = own.filter = filter;
    const std::vector<TrialRecord> mine = records_of(options, "tcf"), expected = records_of(own, "tcf");
    if (filter == Filter::none) {
      EXPECT_EQ(mine, expected);
    } else {
      // consimd brings its own pose into place on all rows after the filter; that of others stands as told.
      for (std::size_t i = 0; i < mine.size(); ++i) EXPECT_EQ(mine[i].success, expected[i].success) << i;
    }
  }
}

TEST(OutsideSolver, SeesTheCallersPointsInDoublePrecision) {
  std::vector<std::shared_ptr<const void>> kept;
  std::vector<std::span<const double>> sources;
  SweepOptions options = study_of({.name = "mine",
                                   .solve =
                                       [&](const OutsideProblem& problem) {
                                         kept.push_back(problem.points);
                                         sources.push_back(problem.source);
                                         return std::nullopt;
                                       }},
                                  {"mine"});
  options.trials = 1;
  options.outlier_ratios = {0.5};
  options.sigmas = {0.1};
  TrialTable table(options);
  run_sweep(table);
  const synth::Problem problem =
      synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.5, .sigma = 0.1, .seed = 5});
  ASSERT_EQ(sources.size(), 1U);
  EXPECT_EQ(std::vector<double>(sources[0].begin(), sources[0].end()), problem.source);
  EXPECT_EQ(table.records()[0].status, "no_consensus");
  EXPECT_FALSE(table.records()[0].success);
}

TEST(OutsideSolver, AWrongReplyNamesSolverAndTrial) {
  const auto named = [](const char* what) {
    return ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("solver mine on trial "),
                                                   HasSubstr(" at outlier ratio 0."), HasSubstr(" and sigma "),
                                                   HasSubstr("wrong reply: "), HasSubstr(what)));
  };
  const auto with = [](auto change) {
    return [change] {
      run_with([change](const OutsideProblem&) {
        RigidTransform pose = RigidTransform::Identity();
        OutsideReply reply = pose;
        change(reply);
        return reply;
      });
    };
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(with([&](OutsideReply& r) { r.pose->translation()(1) = nan; }), named("not finite"));
  EXPECT_THAT(with([&](OutsideReply& r) { r.pose->matrix()(0, 0) = nan; }), named("not finite"));
  EXPECT_THAT(with([](OutsideReply& r) { r.pose->matrix()(2, 2) = -1.0; }), named("reflection"));
  EXPECT_THAT(with([](OutsideReply& r) { r.pose->matrix()(0, 0) = 1.1; }), named("not a rotation"));
  EXPECT_THAT(with([](OutsideReply& r) { r.inliers = {{7, 200}}; }), named("inlier 200 is no row of 200"));
  EXPECT_THAT(with([](OutsideReply& r) { r.inliers = {{7, 7}}; }), named("inlier 7 is there twice"));
  EXPECT_THAT(with([](OutsideReply& r) { r.status = "splendid"; }), named("unknown status 'splendid'"));
  EXPECT_THAT(with([](OutsideReply& r) { r.status = "no_consensus"; }), named("status no_consensus with a pose"));
  EXPECT_THAT(with([&](OutsideReply& r) { r.seconds = nan; }), named("time"));
  EXPECT_NO_THROW(with([](OutsideReply& r) { r.inliers = {{9, 7}}; })());
}

TEST(OutsideSolver, WhatItThrowsEndsTheStudy) {
  EXPECT_THAT([] { run_with([](const OutsideProblem&) -> OutsideReply { throw std::logic_error("mine"); }); },
              ThrowsMessage<std::logic_error>("mine"));
}

TEST(OutsideSolver, BadOnesAreRefused) {
  const auto refuse = [](OutsideSolver solver, const char* what, const std::vector<std::string>& listed = {}) {
    EXPECT_THAT([&] { const TrialTable table(study_of(solver, listed.empty() ? std::vector{solver.name} : listed)); },
                ThrowsMessage<std::invalid_argument>(HasSubstr(what)));
    CompareOptions options;
    options.tables.solvers = listed.empty() ? std::vector{solver.name} : listed;
    options.tables.outside = {solver};
    EXPECT_THAT([&] { static_cast<void>(make_comparison(options)); },
                ThrowsMessage<std::invalid_argument>(HasSubstr(what)));
  };
  refuse({.name = "tcf"}, "consimd has one of this name");
  refuse({.name = "IRLS"}, "consimd has one of this name");
  refuse({.name = "plain-ransac-7"}, "consimd has one of this name");
  refuse({.name = "a,b"}, "solver 'a,b': expected a name");
  refuse({.name = ""}, "expected a name");
  refuse({.name = "yours"}, "yours: it is not in the list", {"tcf"});
  refuse({.name = "mine", .time_limit = -1.0}, "time limit");
  EXPECT_THAT(
      [] {
        TrialTable(study_of({.name = "mine"}, {"mine", "mine"}));
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("given twice")));
  TrialTable nothing(study_of({.name = "mine"}));
  EXPECT_THAT([&] { run_sweep(nothing); }, ThrowsMessage<std::invalid_argument>(HasSubstr("no function to call")));
}

TEST(OutsideSolver, AStudyIsResumedAndMergedAndKnowsItsSolver) {
  const test::TemporaryFolder folder;
  const OutsideSolver mine{.name = "mine", .version = "1", .solve = tcf};
  TrialTable whole(study_of(mine));
  run_sweep(whole);

  std::vector<std::filesystem::path> shards;
  for (std::uint32_t index = 1; index <= 2; ++index) {
    shards.push_back(folder / folder_name({index, 2}));
    for (const std::size_t stop_after : {std::size_t{2}, whole.size()}) {  // stopped, then resumed
      TrialTable table(study_of(mine), Shard{index, 2});
      StudyFolder files(shards.back(), table, {}, false);
      std::atomic<std::size_t> done = table.filled();
      run_sweep(table, {.on_trial =
                            [&](const TrialRecord& record) {
                              files.append(record);
                              ++done;
                            },
                        .stop_requested = [&] { return done >= stop_after; }});
      if (table.complete()) files.finish(table, {});
    }
  }
  EXPECT_EQ(timeless(merge_shards(shards, false).table), timeless(whole));

  const auto open = [&](const OutsideSolver& solver) {
    return [&, solver] {
      TrialTable table(study_of(solver), Shard{1, 2});
      const StudyFolder files(shards.front(), table, {}, false);
    };
  };
  const auto refused = [](const char* what) { return ThrowsMessage<std::runtime_error>(HasSubstr(what)); };
  EXPECT_NO_THROW(open(mine)());
  EXPECT_THAT(open({.name = "mine", .version = "2"}), refused("it has outside mine version 1, not 2"));
  EXPECT_THAT(open({.name = "mine", .command = "exec:x", .version = "1"}),
              refused("it has outside mine command function, not exec:x"));
  EXPECT_THAT(open({.name = "mine", .version = "1", .time_limit = 3.0}),
              refused("it has outside mine time limit 0.0, not 3.0"));
}

TEST(OutsideSolver, AComparisonIsResumedAndKnowsItsSolver) {
  const test::TemporaryFolder folder;
  const auto options_with = [](std::string version) {
    CompareOptions options;
    options.synthetic = {"facade"};
    options.trials = 2;
    options.tables.tables = {"solvers", "boost"};
    options.tables.solvers = {"mine", "tcf"};
    options.tables.outside = {{.name = "mine", .version = std::move(version), .solve = tcf}};
    return options;
  };
  const auto rows = [](const Comparison& comparison) {
    std::vector<std::string> texts;
    for (RunRecord run : comparison.done()) {
      run.seconds = 0.0;
      texts.push_back(to_csv_row(run));
    }
    return texts;
  };
  Comparison whole = make_comparison(options_with("1"));
  run_comparison(whole);
  EXPECT_EQ(whole.runs_of("facade", "tcf+mine").size(), 2U);
  EXPECT_EQ(whole.runs_of("facade", "mine")[0].rotation_error_deg,
            whole.runs_of("facade", "tcf")[0].rotation_error_deg);

  const auto open = [&](const std::string& version, std::size_t stop_after) {
    Comparison comparison = make_comparison(options_with(version));
    const ComparisonFacts facts{.options = option_texts(options_with(version)), .isa = {}};
    ComparisonFolder files(folder / "comparison", comparison, facts, false);
    run_comparison(comparison, {.on_run = [&](const RunRecord& record) { files.append(record); },
                                .stop_requested = [&] { return comparison.filled() >= stop_after; }});
    return rows(comparison);
  };
  EXPECT_EQ(open("1", 3).size(), 3U);
  EXPECT_EQ(open("1", whole.size()), rows(whole));
  EXPECT_THAT([&] { open("2", 0); },
              ThrowsMessage<std::runtime_error>(HasSubstr("it has outside mine version 1, not 2")));
}

TEST(ReplyText, TakesPosesNoneAndTimes) {
  EXPECT_FALSE(parse_reply("none").pose);
  EXPECT_EQ(parse_reply("none time 0.25\r").seconds, 0.25);
  const ReplyText rows = parse_reply("1 0 0 4, 0 1 0 5,0 0\t1 6e0 time 1");
  ASSERT_TRUE(rows.pose);
  EXPECT_EQ(rows.pose->translation(), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(rows.seconds, 1.0);
  EXPECT_TRUE(parse_reply("1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1").pose);
}

TEST(ReplyText, SaysWhatIsWrong) {
  const auto refused = [](const char* line, const char* what) {
    EXPECT_THAT([&] { static_cast<void>(parse_reply(line)); }, ThrowsMessage<std::invalid_argument>(HasSubstr(what)))
        << line;
  };
  refused("", "expected 12 or 16 numbers or none, got 0 words ''");
  refused("1 2 3", "expected 12 or 16 numbers or none, got 3 words '1 2 3'");
  refused("None", "got 1 word 'None'");
  refused("1 0 0 4 0 x 0 5 0 0 1 6", "'x' is no number");
  refused("1 0 0 4 0 1 0 nan 0 0 1 6", "'nan' is not finite");
  refused("1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 2", "the last row must be 0 0 0 1");
  refused("none time -1", "time -1 is below 0");
  refused("none time soon", "'soon' is no number");
}

}  // namespace
}  // namespace consimd::studies
