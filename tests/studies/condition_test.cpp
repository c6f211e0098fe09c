#include <consimd/studies/condition.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "small_study.hpp"

namespace consimd::studies {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Condition, ValuesReadBackFromTheirText) {
  for (const BoundFactor& factor : {BoundFactor(), BoundFactor(0.1), BoundFactor(1.0), BoundFactor(1.0 / 3.0)}) {
    EXPECT_EQ(parse_bound_factor(to_string(factor)), factor);
  }
  EXPECT_EQ(to_string(BoundFactor(2.0)), "2");
  EXPECT_EQ(to_string(BoundFactor()), "estimated");
  for (const ScaleKnowledge scale : {ScaleKnowledge::known, ScaleKnowledge::unknown}) {
    EXPECT_EQ(scale_knowledge_by_name(to_string(scale)), scale);
  }
}

TEST(Condition, BadTextsAreRefused) {
  for (const char* const text : {"", "0", "-1", "nan", "inf", "1x", "guessed"}) {
    EXPECT_THAT([&] { (void)parse_bound_factor(text); },
                ThrowsMessage<std::invalid_argument>(
                    HasSubstr("expected a number > 0 or estimated, got '" + std::string(text) + "'")));
  }
  EXPECT_THAT([] { (void)scale_knowledge_by_name("guessed"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("scale 'guessed': expected one of: known, unknown")));
}

TEST(Condition, AllValuesMeetAllOthers) {
  SweepOptions options = small_study();
  options.families = {"gaussian", "decoy"};
  options.points = {100, 200};
  options.bound_factors = {1.0, std::nullopt};
  const std::vector<Condition> all = options.conditions();
  ASSERT_EQ(all.size(), 8u);
  EXPECT_EQ(all[0], (Condition{.points = 100}));
  EXPECT_EQ(all[1], (Condition{.points = 100, .bound_factor = std::nullopt}));
  EXPECT_EQ(all[2], (Condition{.points = 200}));
  EXPECT_EQ(all[7], (Condition{.family = "decoy", .points = 200, .bound_factor = std::nullopt}));
  EXPECT_EQ(options.cells(), 8u * 4u);
}

TEST(Condition, OnlyWhatThePaperDoesNotVaryIsBeyondIt) {
  EXPECT_FALSE(SweepOptions().beyond_paper());
  EXPECT_FALSE(small_study().beyond_paper());
  for (const auto& vary : std::vector<void (*)(SweepOptions&)>{
           [](SweepOptions& o) { o.families = {"decoy"}; }, [](SweepOptions& o) { o.no_pose = 0.1; },
           [](SweepOptions& o) { o.scales = {ScaleKnowledge::unknown}; },
           [](SweepOptions& o) { o.bound_factors = {2.0}; }, [](SweepOptions& o) { o.bound_factors = {std::nullopt}; },
           [](SweepOptions& o) {
             o.points = {100, 200};
           }}) {
    SweepOptions options = small_study();
    vary(options);
    EXPECT_TRUE(options.beyond_paper());
  }
}

TEST(Condition, ProblemsWithoutAPoseAreSpreadOverTheTrials) {
  SweepOptions options = small_study();
  for (const double share : {0.0, 0.1, 0.25, 0.5, 0.9}) {
    options.no_pose = share;
    EXPECT_TRUE(options.has_true_pose(0)) << "or a cell would have no recall";
    double without = 0.0;
    for (std::uint32_t trial = 0; trial < 1000; ++trial) {
      without += !options.has_true_pose(trial);
      EXPECT_LE(std::abs(without - share * (trial + 1.0)), 1.0);
    }
  }
}

TEST(Condition, BadValuesAreRefused) {
  struct Case {
    void (*spoil)(SweepOptions&);
    const char* says;
  };
  for (const auto& [spoil, says] : std::vector<Case>{
           {[](SweepOptions& o) { o.families = {}; }, "family: at least one value is needed"},
           {[](SweepOptions& o) { o.families = {"magic"}; }, "family 'magic': expected one of: gaussian, "},
           {[](SweepOptions& o) {
              o.families = {"decoy", "decoy"};
            },
            "family: decoy is given twice"},
           {[](SweepOptions& o) { o.points = {}; }, "points: at least one value is needed"},
           {[](SweepOptions& o) {
              o.points = {200, 200};
            },
            "points: 200 is given twice"},
           {[](SweepOptions& o) {
              o.points = {200, 5};
            },
            "outliers: a ratio of 0.8 leaves fewer than 3 inliers among 5 points"},
           {[](SweepOptions& o) { o.bound_factors = {}; }, "bound_factor: at least one value is needed"},
           {[](SweepOptions& o) { o.bound_factors = {0.0}; }, "bound_factor: expected a number above 0 "},
           {[](SweepOptions& o) { o.bound_factors = {kNaN}; }, "bound_factor: expected a number above 0 "},
           {[](SweepOptions& o) { o.bound_factors = {1e7}; }, "at most 1000000, got 10000000"},
           {[](SweepOptions& o) {
              o.bound_factors = {std::nullopt, std::nullopt};
            },
            "bound_factor: estimated is given twice"},
           {[](SweepOptions& o) { o.scales = {}; }, "scale: at least one value is needed"},
           {[](SweepOptions& o) {
              o.scales = {ScaleKnowledge::known, ScaleKnowledge::known};
            },
            "scale: known is given twice"},
           {[](SweepOptions& o) { o.scales = {ScaleKnowledge::unknown}; }, "solver 'tcf'"},
           {[](SweepOptions& o) {
              o.scales = {ScaleKnowledge::unknown};
              o.solvers = {"pcr99"};
              o.filter = Filter::tcf;
            },
            "scale unknown: filter 'tcf'"},
           {[](SweepOptions& o) {
              o.scales = {ScaleKnowledge::unknown};
              o.solvers = {"pcr99"};
              o.bound_factors = {std::nullopt};
            },
            "scale unknown: a noise bound is needed"},
           {[](SweepOptions& o) {
              o.scales = {ScaleKnowledge::unknown};
              o.solvers = {"mine"};
              o.outside = {{.name = "mine"}};
            },
            "scale unknown: solver mine is not consimd's"},
           {[](SweepOptions& o) { o.no_pose = 1.0; }, "no_pose: expected a share in [0, 1), got 1"},
           {[](SweepOptions& o) { o.no_pose = -0.1; }, "no_pose: expected a share in [0, 1)"},
           {[](SweepOptions& o) { o.no_pose = kNaN; }, "no_pose: expected a share in [0, 1)"}}) {
    SweepOptions options = small_study();
    spoil(options);
    try {
      validate(options);
      ADD_FAILURE() << says << ": not refused";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(says));
    }
  }
}

}  // namespace
}  // namespace consimd::studies
