#include <consimd/studies/compare_options.hpp>

#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <consimd/synth/noise_study.hpp>
#include <consimd/synth/problem_files.hpp>
#include "temporary_folder.hpp"

namespace consimd::studies {
namespace {

using test::TemporaryFolder;
using test::write_text;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

CompareOptions small() {
  CompareOptions options;
  options.synthetic = {"facade"};
  options.trials = 2;
  options.tables.solvers = {"tcf", "ransac"};
  return options;
}

std::vector<std::string> groups_of(const CompareOptions& options) {
  const Comparison comparison = make_comparison(options);
  std::vector<std::string> names;
  for (const CaseGroup& group : comparison.groups()) names.push_back(group.name);
  return names;
}

TEST(CompareOptions, AskForAllSolversOnAllStandIns) {
  const Comparison comparison = make_comparison({});
  EXPECT_EQ(comparison.groups().size(), 10u);
  EXPECT_EQ(comparison.groups().front().methods, CompareOptions().tables.solvers);
  EXPECT_EQ(comparison.size(), 10 * 20 * CompareOptions().tables.solvers.size());
}

TEST(CompareOptions, PutFilesBeforeSyntheticData) {
  const TemporaryFolder folder;
  const synth::Problem problem = synth::noise_study_problem({.correspondences = 50, .outlier_ratio = 0.2});
  synth::write_problem(problem, folder / "data/a");
  write_text(folder / "data/a/case.json", R"({"noise_bound": 3, "sequence": "1", "max_rotation_error_deg": 5,
                                             "max_translation_error_m": 0.5})");
  CompareOptions options = small();
  options.cases = folder / "data";
  options.synthetic = {"noise", "facade"};
  options.outliers = "0.5";
  EXPECT_THAT(groups_of(options), ElementsAre("data 1", "facade", "noise 50 %"));
  options.synthetic = {};
  EXPECT_THAT(groups_of(options), ElementsAre("data 1"));

  const Case file = make_comparison(options).groups().front().cases.front();
  EXPECT_EQ(file.load().noise_bound, 3.0);
  EXPECT_EQ(file.limits, (PoseLimits{5.0, 0.5}));
  EXPECT_EQ(file.load().problem.source, problem.source);
}

TEST(CompareOptions, NameTheFault) {
  const auto refused = [](auto change, const std::string& says) {
    CompareOptions options = small();
    change(options);
    EXPECT_THAT([&] { (void)make_comparison(options); }, ThrowsMessage<std::invalid_argument>(HasSubstr(says)));
  };
  refused([](CompareOptions& o) { o.synthetic = {"moon"}; }, "synthetic: ");
  refused([](CompareOptions& o) { o.seeds = 0; }, "seeds: expected at least 1, got 0");
  refused([](CompareOptions& o) { o.trials = 0; }, "trials: expected at least 1, got 0");
  refused([](CompareOptions& o) { o.iteration_problems = 0; }, "iteration problems: expected at least 1, got 0");
  refused([](CompareOptions& o) { o.tables.solvers = {"magic"}; }, "magic");
  refused(
      [](CompareOptions& o) {
        o.synthetic = {"noise"};
        o.sigma = "1,x";
      },
      "sigma: 'x' is not a finite number");
  refused(
      [](CompareOptions& o) {
        o.tables.filtered = true;
        o.tables.tables = {"boost"};
      },
      "filter: it is for the tables solvers");
}

TEST(CompareOptions, AreToldAsText) {
  CompareOptions options = small();
  options.tables.filtered = true;
  const std::vector<OptionText> texts = option_texts(options);
  EXPECT_THAT(texts, testing::Contains(OptionText("solver", "tcf,ransac")));
  EXPECT_THAT(texts, testing::Contains(OptionText("filter", "tcf")));
  EXPECT_THAT(texts, testing::Contains(OptionText("scales", "0.2,0.5,1,2,5")));
}

}  // namespace
}  // namespace consimd::studies
