#include <consimd/studies/paper_tables.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <consimd/studies/method.hpp>
#include <consimd/studies/run_statistics.hpp>
#include <consimd/studies/table_runs.hpp>

namespace consimd::studies {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

RunRecord run_of(std::string method, double rotation, double translation, bool success, double seconds) {
  return {.group = "arch",
          .case_name = "0",
          .method = std::move(method),
          .success = success,
          .rotation_error_deg = rotation,
          .translation_error = translation,
          .rows = 1000,
          .inliers = 100,
          .kept = 50,
          .kept_inliers = 40,
          .seconds = seconds};
}

TEST(RunStatistics, AreThoseOfTheRuns) {
  const std::vector<RunRecord> runs{run_of("tcf", 0.1, 0.01, true, 0.001), run_of("tcf", 0.3, 0.03, true, 0.003),
                                    run_of("tcf", 9.0, 5.0, false, 0.002), run_of("tcf", kNaN, kNaN, false, 0.008)};
  const RunStatistics s = run_statistics(runs);
  EXPECT_EQ(s.recall, 0.5);
  EXPECT_NEAR(s.rotation_deg.mean_of_successes, 0.2, 1e-12);
  EXPECT_NEAR(s.rotation_deg.median_of_all, 4.65, 1e-12);
  EXPECT_NEAR(s.translation.mean_of_successes, 0.02, 1e-12);
  EXPECT_NEAR(s.seconds_median, 0.0025, 1e-12);
  EXPECT_NEAR(s.inlier_ratio, 0.1, 1e-12);
  EXPECT_NEAR(s.kept_inlier_ratio, 0.8, 1e-12);
  EXPECT_EQ(s.kept, 50.0);
  const RunStatistics none = run_statistics({});
  EXPECT_TRUE(std::isnan(none.recall));
  EXPECT_EQ(none.recall_interval.high, 1.0);
}

TEST(RunStatistics, CellsShowWhatIsKnown) {
  EXPECT_EQ(percent(0.8756), "87.6");
  EXPECT_EQ(percent(kNaN), "-");
  EXPECT_EQ(interval({0.5, 1.0}), "50.0 - 100.0");
  EXPECT_EQ(error({0.1234, 12.34}), "0.123 (12.3)");
  EXPECT_EQ(error({kNaN, std::numeric_limits<double>::infinity()}), "- (-)");
  EXPECT_EQ(milliseconds(0.00123), "1.23");
  EXPECT_EQ(milliseconds(0.1234), "123");
  EXPECT_EQ(count(59.6), "60");
}

TEST(TextTable, IsAlignedMarkdown) {
  const TextTable table{.name = "t",
                        .title = "Title",
                        .caption = {"One.", "Two."},
                        .columns = {"data", "recall %"},
                        .rows = {{"arch", "9.5"}, {"grün", "100.0"}}};
  EXPECT_EQ(to_markdown(table),
            "### Title\n\nOne.\nTwo.\n\n"
            "| data | recall % |\n"
            "|------|---------:|\n"
            "| arch |      9.5 |\n"
            "| grün |    100.0 |\n");
  EXPECT_EQ(to_csv(table), "data,recall %\narch,9.5\ngrün,100.0\n");
}

TableOptions all_tables() {
  return {.tables = {"solvers", "boost", "stages", "poses", "iterations"},
          .solvers = {"tcf", "ransac"},
          .iterations = {100, 1000},
          .scales = {0.2, 5.0}};
}

TEST(PaperTables, NeedTheirMethods) {
  TableOptions options = all_tables();
  EXPECT_THAT(methods_of(options), ElementsAre("tcf", "tcf+tcf", "ransac", "tcf+ransac", "1R+2R", "1R", "2R", "3R",
                                               "1R+3R", "2R+3R", "1R+2R+3R", "1R+2R+IRLS", "1R+2R+3R+IRLS"));
  EXPECT_THAT(iteration_methods(options), ElementsAre("plain-ransac-100", "plain-ransac-1000", "tcf"));
  options.tables = {"solvers"};
  EXPECT_THAT(methods_of(options), ElementsAre("tcf", "ransac"));
  options.filtered = true;
  EXPECT_THAT(methods_of(options), ElementsAre("tcf+tcf", "tcf+ransac"));
  EXPECT_TRUE(iteration_methods(options).empty());
  options.tables = {"iterations"};
  EXPECT_TRUE(methods_of(options).empty());
}

TEST(PaperTables, TellWhatWasRun) {
  const TableOptions options = all_tables();
  std::vector<CaseGroup> groups = stand_in_groups({"arch"}, 1, 1, "paper");
  groups.front().methods = methods_of(options);
  groups.push_back(iteration_group(options, 1, 1));
  Comparison comparison(std::move(groups), 1);
  for (const std::string& method : methods_of(options)) {
    RunRecord run = run_of(method, 0.25, 0.04, true, 0.005);
    run.seed = 1;
    comparison.put(run);
  }
  RunRecord few = run_of(plain_ransac(100), kNaN, kNaN, false, 0.001),
            many = run_of(plain_ransac(1000), 1, 1, true, 0.002), rival = run_of("tcf", 1, 1, true, 0.003);
  for (RunRecord* run : {&few, &many, &rival}) {
    run->group = "2 % inliers";
    run->case_name = "sigma 1 trial 0";
    run->seed = 1;
    comparison.put(*run);
  }
  const std::vector<TextTable> tables = comparison_results(options, comparison).tables;
  ASSERT_EQ(tables.size(), 5u);
  const std::string errors = "0.250 (0.250)", shifts = "0.040 (0.040)";
  EXPECT_EQ(tables[0].name, "solvers");
  EXPECT_THAT(tables[0].rows,
              ElementsAre(ElementsAre("arch", "tcf", "100.0", "20.7 - 100.0", errors, shifts, "5.00"),
                          ElementsAre("arch", "ransac", "100.0", "20.7 - 100.0", errors, shifts, "5.00")));
  EXPECT_EQ(tables[1].rows.size(), 4u);
  EXPECT_THAT(tables[1].rows[0], ElementsAre("arch", "tcf", "1000", "10.0", "100.0", errors, shifts, "5.00"));
  EXPECT_THAT(tables[1].rows[1], ElementsAre("arch", "tcf+tcf", "50", "80.0", "100.0", errors, shifts, "5.00"));
  ASSERT_EQ(tables[2].rows.size(), 8u);
  EXPECT_THAT(tables[2].rows[0], ElementsAre("arch", "none", "10.0", "100", "1000", "-"));
  EXPECT_THAT(tables[2].rows[7], ElementsAre("arch", "1R+2R+3R", "80.0", "40", "50", "5.00"));
  EXPECT_EQ(tables[3].rows.size(), 3u);
  EXPECT_THAT(tables[4].rows, ElementsAre(ElementsAre("plain ransac", "100", "0.0", "0.0 - 79.3", "0.1", "1.00"),
                                          ElementsAre("plain ransac", "1000", "100.0", "20.7 - 100.0", "0.8", "2.00"),
                                          ElementsAre("tcf", "-", "100.0", "20.7 - 100.0", "-", "3.00")));
  for (std::size_t t = 0; t < 4; ++t) {
    EXPECT_THAT(tables[t].caption.front(), HasSubstr("synthetic stand-in for ETH Arch, not its data")) << t;
  }
  EXPECT_THAT(tables[0].caption[1], HasSubstr("arch: 5 deg, 0.5 m"));
  EXPECT_THAT(tables[4].caption[1], HasSubstr("RMSE of the true inliers below the noise bound"));
}

TEST(PaperTables, ThePipelineIsRunOnScans) {
  TableOptions options = all_tables();
  options.tables = {"data", "pipeline"};
  options.outside = {{.name = "mine"}};
  options.solvers = {"tcf", "mine", "ransac"};
  EXPECT_NO_THROW(validate(options));
  EXPECT_THAT(methods_of(options), ElementsAre("1R"));
  EXPECT_THAT(scan_methods(options), ElementsAre("scans+tcf", "scans+ransac"));
  CaseGroup group{.name = "arch", .cases = {{.name = "0", .distance = 16.0}, {.name = "1", .distance = 18.0}}};
  group.methods = {"1R", "scans+tcf", "scans+ransac"};
  Comparison comparison({group}, 1);
  for (const auto& [name, success] : {std::pair("0", true), std::pair("1", false)}) {
    for (const std::string& method : group.methods) {
      RunRecord run = run_of(method, 0.25, 0.04, success, 0.1);
      run.case_name = name;
      run.seed = 1;
      run.status = method == "scans+tcf" ? "success" : "no_consensus";
      comparison.put(run);
    }
  }
  const std::vector<TextTable> tables = comparison_results(options, comparison).tables;
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_THAT(tables[0].rows, ElementsAre(ElementsAre("arch", "2", "17.00", "1000", "10.0")));
  const std::string errors = "0.250 (0.250)", shifts = "0.040 (0.040)", range = "9.5 - 90.5";
  EXPECT_THAT(tables[1].rows, ElementsAre(ElementsAre("arch", "tcf", "50.0", range, "50.0", errors, shifts, "100"),
                                          ElementsAre("arch", "ransac", "50.0", range, "0.0", errors, shifts, "100")));
  options.solvers = {"mine"};
  EXPECT_THROW(validate(options), std::invalid_argument);
}

TEST(PaperTables, ScalesAreThoseOfSolversThatFindThem) {
  TableOptions options = all_tables();
  EXPECT_TRUE(scale_groups(options, 1, 1).empty());
  options.tables = {"scales"};
  options.solvers = {"teaser", "tcf", "pcr99"};
  EXPECT_NO_THROW(validate(options));
  EXPECT_THAT(scale_methods(options), ElementsAre("scale+teaser", "scale+pcr99"));
  EXPECT_TRUE(methods_of(options).empty());
  Comparison comparison(scale_groups(options, 1, 1), 1);
  ASSERT_EQ(comparison.groups().size(), 2u);
  EXPECT_THAT(comparison.groups()[0].provenance, HasSubstr("90 % outliers, sigma 0.1, 1, 2.5, 5 m, source divided"));
  for (const double error : {0.0001, 0.0123}) {
    RunRecord run = run_of("scale+teaser", 0.25, 0.04, true, 0.005);
    run.group = "scale 0.2";
    run.case_name = error < 0.001 ? "sigma 1 trial 0" : "sigma 5 trial 0";
    run.seed = 1;
    run.scale_error = error;
    comparison.put(run);
  }
  const TextTable table = comparison_results(options, comparison).tables.front();
  EXPECT_EQ(table.name, "scales");
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_THAT(table.rows[0], ElementsAre("scale 0.2", "teaser", "100.0", "34.2 - 100.0", "1.23", "0.250 (0.250)",
                                         "0.040 (0.040)", "5.00"));
  EXPECT_THAT(table.rows[1], ElementsAre("scale 0.2", "pcr99", "-", "0.0 - 100.0", "-", "- (-)", "- (-)", "-"));
  EXPECT_EQ(table.rows[2][0], "scale 5");
}

TEST(PaperTables, UnfinishedOnesSaySo) {
  const TableOptions options{.tables = {"solvers"}, .solvers = {"tcf"}, .iterations = {1}, .scales = {1.0}};
  std::vector<CaseGroup> groups = stand_in_groups({"arch"}, 1, 1, "case");
  groups.front().methods = methods_of(options);
  const Comparison nothing(std::move(groups), 1);
  const TextTable table = comparison_results(options, nothing).tables.front();
  EXPECT_THAT(table.rows, ElementsAre(ElementsAre("arch", "tcf", "-", "0.0 - 100.0", "- (-)", "- (-)", "-")));
  EXPECT_THAT(table.caption[2], HasSubstr("Unfinished: 0 of 1 runs"));
}

TEST(PaperTables, PairsSayWhoIsBetterAndWhere) {
  TableOptions options = all_tables();
  options.tables = {"pairs", "quantiles"};
  EXPECT_THAT(methods_of(options), ElementsAre("tcf", "ransac"));
  std::vector<CaseGroup> groups = stand_in_groups({"arch", "trees"}, 10, 1, "paper");
  for (CaseGroup& group : groups) group.methods = methods_of(options);
  Comparison comparison(std::move(groups), 1);
  for (const CaseGroup& group : comparison.groups()) {
    for (std::uint64_t k = 0; k < 10; ++k) {
      for (const std::string& method : group.methods) {
        const bool success = method == "tcf" || group.name == "trees";
        RunRecord run = success ? run_of(method, method == "tcf" ? 0.25 : 0.5, 0.04, true, 0.005)
                                : run_of(method, kNaN, kNaN, false, 0.005);
        run.group = group.name;
        run.case_name = std::to_string(k);
        run.seed = 1 + k;
        run.oracle_rotation_error_deg = 0.25;
        run.oracle_translation_error = 0.02;
        comparison.put(run);
      }
    }
  }
  const std::vector<TextTable> tables = comparison_results(options, comparison).tables;
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[0].name, "pairs");
  ASSERT_EQ(tables[0].rows.size(), 1u);
  const std::vector<std::string>& pair = tables[0].rows[0];
  EXPECT_THAT(std::vector(pair.begin(), pair.begin() + 9),
              ElementsAre("tcf", "ransac", "tcf", "arch", "20", "10", "0", "0.002", "0.002"));
  EXPECT_THAT(pair[9], HasSubstr("50 ("));
  EXPECT_EQ(pair[10], "-0.25 (-0.25 .. -0.25)");
  EXPECT_EQ(pair[12], "1 (1 .. 1)");
  ASSERT_EQ(tables[1].rows.size(), 6u);
  EXPECT_THAT(tables[1].rows[1],
              ElementsAre("arch", "ransac", "10", "0.0", "0.0 - 27.8", "-", "-", "-", "-", "-", "-", "-", "-", "-"));
  EXPECT_THAT(tables[1].rows[5], ElementsAre("all groups", "ransac", "20", "50.0", "29.9 - 70.1", "0.5", "-", "0.04",
                                             "-", "0.25", "0.25", "5.00", "-", "-"));
  for (const TextTable& table : tables) EXPECT_THAT(table.caption[1], HasSubstr("arch, trees: 5 deg, 0.5 m"));
  options.solvers = {"tcf"};
  EXPECT_NO_THROW(validate(options));
  options.tables = {"pairs"};
  EXPECT_THROW(validate(options), std::invalid_argument);
}

TEST(PaperTables, RefuseBadOptions) {
  for (const auto& spoil : std::vector<void (*)(TableOptions&)>{
           [](TableOptions& o) { o.tables = {}; }, [](TableOptions& o) { o.tables = {"magic"}; },
           [](TableOptions& o) { o.solvers = {}; }, [](TableOptions& o) { o.solvers = {"magic"}; },
           [](TableOptions& o) {
             o.solvers = {"tcf", "tcf"};
           },
           [](TableOptions& o) { o.preset = "magic"; }, [](TableOptions& o) { o.iterations = {}; },
           [](TableOptions& o) {
             o.iterations = {5, 5};
           },
           [](TableOptions& o) { o.scales = {}; }, [](TableOptions& o) { o.scales = {0.0}; },
           [](TableOptions& o) { o.scales = {std::numeric_limits<double>::infinity()}; },
           [](TableOptions& o) { o.tables = {"scales"}; }}) {
    TableOptions options = all_tables();
    EXPECT_NO_THROW(validate(options));
    spoil(options);
    EXPECT_THROW(validate(options), std::invalid_argument);
  }
}

}  // namespace
}  // namespace consimd::studies
