#include <consimd/solvers/registry.hpp>

#include <consimd/solvers/mac.hpp>
#include <consimd/solvers/ransac.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/noise_study.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The message that a call is rejected with; "accepted" if it is not.
template <typename Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

std::string message_of(const std::string& text) {
  return message_of([&] { static_cast<void>(SolverChoice(text)); });
}

const SolverOption& option(std::string_view solver, std::string_view name) {
  return option_named(SolverChoice(solver).solver().options, name, "solver");
}

/// Values just outside the range of an option, of its own kind.
std::vector<OptionValue> values_outside(const SolverOption& option) {
  std::vector<OptionValue> values;
  if (const auto* whole = std::get_if<WholeRange>(&option.range)) {
    if (whole->least > 0) values.emplace_back(whole->least - 1);
  } else if (const auto* real = std::get_if<RealRange>(&option.range)) {
    values.emplace_back(std::nan(""));
    values.emplace_back(real->least_included ? std::nextafter(real->least, -kInfinity) : real->least);
    if (!(real->most == kInfinity && real->most_included)) {
      values.emplace_back(real->most_included ? std::nextafter(real->most, kInfinity) : real->most);
    }
  }
  return values;
}

/// The ends of an option's range, or its names.
std::vector<OptionValue> values_inside(const SolverOption& option) {
  std::vector<OptionValue> values;
  if (std::holds_alternative<TruthRange>(option.range)) {
    values = {OptionValue(false), OptionValue(true)};
  } else if (const auto* whole = std::get_if<WholeRange>(&option.range)) {
    values.emplace_back(whole->least);
  } else if (const auto* real = std::get_if<RealRange>(&option.range)) {
    values.emplace_back(real->least_included ? real->least : real->least + 1e-3);
    values.emplace_back(real->most_included ? real->most : std::min(1e3, real->most - 1e-3));
  } else {
    for (const std::string& name : std::get<NameRange>(option.range).names) values.emplace_back(name);
  }
  if (option.may_be_none) values.emplace_back(std::monostate());
  return values;
}

TEST(Registry, EveryEntryIsWhole) {
  for (const Solver& solver : solvers()) {
    SCOPED_TRACE(solver.name);
    EXPECT_EQ(solver.name.find_first_of(":,= "), std::string::npos);
    for (const std::string* text : {&solver.description, &solver.memory, &solver.stops_early, &solver.advice}) {
      EXPECT_FALSE(text->empty());
      EXPECT_EQ(text->find('\n'), std::string::npos);
    }
    ASSERT_TRUE(solver.run);
    std::set<std::string> names;
    for (const SolverOption& option : solver.options) {
      EXPECT_TRUE(names.insert(option.name).second) << option.name;
      EXPECT_FALSE(option.meaning.empty()) << option.name;
      EXPECT_EQ(message_of([&] { require_allowed(option, option.default_value); }), "accepted");
    }
    for (const Preset& preset : solver.presets) {
      for (const OptionSetting& setting : preset.settings) {
        const SolverOption& option = option_named(solver.options, setting.name, preset.name);
        EXPECT_EQ(message_of([&] { require_allowed(option, setting.value); }), "accepted");
      }
    }
  }
}

TEST(Registry, DefaultsAreThoseOfTheOptions) {
  EXPECT_EQ(option("tcf", "confidence").default_value, OptionValue(TcfOptions().confidence));
  EXPECT_EQ(option("ransac", "confidence").default_value, OptionValue(*RansacOptions().confidence));
  EXPECT_EQ(option("ransac", "max_iterations").default_value,
            OptionValue(std::uint64_t{RansacOptions().max_iterations}));
  EXPECT_EQ(option("mac", "weighted_fit").default_value, OptionValue(MacOptions().weighted_fit));
  EXPECT_EQ(option("sc2_pcr", "ranking").default_value, OptionValue("inlier_count"));
  EXPECT_EQ(SolverChoice("ransac-10k").value("confidence"), OptionValue());
}

TEST(Registry, SolversTakeWhatTheirOptionsSay) {
  // The registry is asked for settings beyond what it checks, so that the solver itself has to.
  const Correspondences correspondences = synth::noise_study_problem({.correspondences = 40}).correspondences();
  for (const Solver& solver : solvers()) {
    for (const SolverOption& option : solver.options) {
      const auto run = [&](const OptionValue& value) {
        std::vector<OptionSetting> settings{{option.name, value}};
        // The second set must not be larger than the first.
        if (option.name == "first_set") settings.push_back({"second_set", std::uint64_t{3}});
        if (option.name == "second_set") settings.push_back({"first_set", std::uint64_t{64}});
        return message_of([&] { static_cast<void>(solver.run(correspondences, {.noise_bound = 3.0}, settings)); });
      };
      for (const OptionValue& value : values_outside(option)) {
        const std::string message = run(value);
        EXPECT_NE(message.find(option.name + " is " + to_string(value)), std::string::npos)
            << solver.name << ", " << to_string(value) << ": " << message;
        EXPECT_EQ(message_of([&] { require_allowed(option, value); }), message);
      }
      // A graph always needs more memory than none.
      if (option.name == "matrix_budget_bytes") continue;
      for (const OptionValue& value : values_inside(option)) {
        EXPECT_EQ(run(value), "accepted") << solver.name << ", " << option.name << " is " << to_string(value);
      }
    }
  }
}

TEST(Registry, OptionsReachTheSolver) {
  const Correspondences correspondences =
      synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.5}).correspondences();
  const Registration direct = register_ransac(
      correspondences, {.noise_bound = 3.0, .seed = 5, .max_iterations = 700, .confidence = std::nullopt});
  const Registration chosen =
      register_by_name("ransac:confidence=none:max_iterations=700", correspondences, {.noise_bound = 3.0, .seed = 5});
  EXPECT_EQ(chosen.T_target_source.matrix(), direct.T_target_source.matrix());
  EXPECT_EQ(chosen.inliers, direct.inliers);
  EXPECT_EQ(chosen.stages.front().iterations, 700u);

  for (const auto& [preset, iterations] : {std::pair("ransac-10k", 10'000u), std::pair("ransac-50k", 50'000u)}) {
    const Registration same = register_by_name(preset, correspondences, {.noise_bound = 3.0, .seed = 5});
    const Registration fixed = register_ransac(
        correspondences, {.noise_bound = 3.0, .seed = 5, .max_iterations = iterations, .confidence = std::nullopt});
    EXPECT_EQ(same.T_target_source.matrix(), fixed.T_target_source.matrix());
    EXPECT_EQ(same.stages.front().iterations, iterations);
  }
  SolverChoice choice("ransac-50k");
  choice.set("max_iterations", std::uint64_t{100});
  EXPECT_EQ(register_by_choice(choice, correspondences, {.noise_bound = 3.0}).stages.front().iterations, 100u);
}

TEST(Registry, LabelsAreOfOneSpelling) {
  EXPECT_EQ(SolverChoice("tcf").label(), "tcf");
  EXPECT_EQ(SolverChoice("ransac-10k").label(), "ransac-10k");
  for (const std::string text :
       {"ransac:max_iterations=10000:confidence=none", "ransac:confidence=none:max_iterations=010000"}) {
    EXPECT_EQ(SolverChoice(text).label(), "ransac:max_iterations=10000:confidence=none");
  }
  EXPECT_EQ(SolverChoice("ransac:confidence=9.90e-1").label(), "ransac:confidence=0.99");
  EXPECT_EQ(SolverChoice("ransac:length_tolerance=infinity").label(), "ransac:length_tolerance=inf");
  EXPECT_EQ(SolverChoice("teaser:refine=false:selection=everything").label(),
            "teaser:selection=everything:refine=false");
  for (const std::string& name : solver_names()) {
    SolverChoice choice(name);
    for (const SolverOption& option : choice.solver().options) choice.set(option.name, choice.value(option.name));
    EXPECT_EQ(SolverChoice(choice.label()).label(), choice.label());
  }
}

TEST(Registry, BadTextsAreNamedWithWhatThereIs) {
  EXPECT_NE(message_of(std::string("magic:x=1"))
                .find("solver is 'magic', expected one of: tcf, tcf-published, ransac, "
                      "ransac-10k"),
            std::string::npos);
  EXPECT_EQ(message_of(std::string("tcf:max_nodes=3")),
            "solver 'tcf' has no option 'max_nodes', expected one of: confidence, max_seeds, matrix_budget_bytes");
  for (const std::string text : {"tcf:", "tcf:=1", "tcf::max_seeds=1", "tcf:Confidence=0.5", "tcf: confidence=0.5"}) {
    EXPECT_NE(message_of(text).find("solver 'tcf' has no option '"), std::string::npos) << message_of(text);
  }
  EXPECT_EQ(message_of(std::string("tcf:max_seeds")),
            "option 'max_seeds' has no value, expected max_seeds=10000 or another value");
  EXPECT_EQ(message_of(std::string("tcf:max_seeds=1:max_seeds=1")),
            "option 'max_seeds' of solver 'tcf' is given twice");
}

struct BadValues {
  std::string solver, option;
  std::vector<std::string> texts;
  std::string expected;
};

TEST(Registry, BadValuesOfEveryKindAreNamed) {
  const std::vector<BadValues> all{
      {"ransac",
       "max_iterations",
       {"", "x", "0", "-1", "1.5", "1e3", " 1", "+1", "4294967296", "nan", "none", "true"},
       "a whole number from 1 to 4294967295"},
      {"sc2_pcr", "first_set", {"2", "65", "", "inf"}, "a whole number from 3 to 64"},
      {"tcf",
       "confidence",
       {"", "0", "1", "-0.1", "nan", "inf", "x", "0.9x", "none", "0,9"},
       "a number above 0 and below 1"},
      {"ransac", "confidence", {"", "0", "1", "nan", "off"}, "a number above 0 and below 1, or none"},
      {"sc2_pcr", "seed_share", {"0", "1.01", "nan"}, "a number above 0 and up to 1"},
      {"sc2_pcr", "length_tolerance", {"0", "-1", "inf", "nan", ""}, "a finite number above 0"},
      {"ransac", "length_tolerance", {"0", "-1", "-inf", "nan", ""}, "a number above 0, or inf"},
      {"mac", "compatibility_threshold", {"-0.1", "1", "nan"}, "a number from 0 and below 1"},
      {"teaser", "refine", {"", "1", "0", "True", "yes", "none"}, "true or false"},
      {"sc2_pcr", "ranking", {"", "best", "Inlier_count", "0", "none"}, "one of: inlier_count, truncated_score"},
      {"teaser", "selection", {"", "clique"}, "one of: maximum_clique, maximum_core, everything"},
  };
  for (const BadValues& bad : all) {
    for (const std::string& text : bad.texts) {
      const std::string message = message_of(bad.solver + ":" + bad.option + "=" + text);
      EXPECT_EQ(message.find(bad.option + " is "), 0u) << text << ": " << message;
      EXPECT_NE(message.find(", expected " + bad.expected), std::string::npos) << text << ": " << message;
    }
    EXPECT_EQ(expectation(option(bad.solver, bad.option)), bad.expected);
  }
}

TEST(Registry, ValuesOfAnotherKindAreRejected) {
  const std::vector<OptionValue> values{std::monostate(), true, std::uint64_t{7}, 0.5, "chain"};
  for (const Solver& solver : solvers()) {
    for (const SolverOption& option : solver.options) {
      for (const OptionValue& value : values) {
        const bool same_kind = value.index() == option.range.index() + 1 ||
                               (option.may_be_none && std::holds_alternative<std::monostate>(value));
        if (same_kind) continue;
        SolverChoice choice(solver.name);
        EXPECT_NE(message_of([&] { choice.set(option.name, value); }).find("expected " + expectation(option)),
                  std::string::npos)
            << solver.name << " took " << to_string(value) << " as " << option.name;
      }
    }
  }
}

TEST(Registry, ScaleIsAnOptionToo) {
  const Correspondences correspondences =
      synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.5, .scale = 2.0}).correspondences();
  const Registration by_option = register_by_name("teaser:estimate_scale=true", correspondences, {.noise_bound = 3.0});
  const Registration by_flag =
      register_by_name("teaser", correspondences, {.noise_bound = 3.0, .estimate_scale = true});
  EXPECT_NEAR(by_option.scale, 2.0, 0.1);
  EXPECT_EQ(by_option.scale, by_flag.scale);
  EXPECT_EQ(by_option.T_target_source.matrix(), by_flag.T_target_source.matrix());
  EXPECT_EQ(message_of([&] { static_cast<void>(register_by_name("teaser:estimate_scale=true", correspondences, {})); }),
            "estimate_scale: needs a noise_bound");
  EXPECT_NE(message_of([&] {
              static_cast<void>(register_by_name("teaser:estimate_scale=false", correspondences,
                                                 {.noise_bound = 3.0, .estimate_scale = true}));
            }).find("is given twice"),
            std::string::npos);
}

TEST(Registry, TakesSolversOfTheCallers) {
  std::vector<Solver> all(solvers().begin(), solvers().end());
  all.push_back({.name = "identity",
                 .description = "says that nothing moved",
                 .needs = "",
                 .memory = "none",
                 .stops_early = "no search to stop",
                 .advice = "in tests",
                 .options = {{.name = "share",
                              .unit = "",
                              .meaning = "of the rows that are inliers",
                              .range = RealRange{.least = 0.0, .most = 1.0, .most_included = true},
                              .default_value = 1.0}},
                 .presets = {},
                 .run = [](const Correspondences& rows, const SolverTask& task, std::span<const OptionSetting> given) {
                   Registration result;
                   result.status = Status::success;
                   result.noise_bound = task.noise_bound;
                   const double share = given.empty() ? 1.0 : std::get<double>(given.front().value);
                   result.inliers.resize(static_cast<std::size_t>(share * static_cast<double>(rows.size())));
                   return result;
                 }});
  const SolverChoice choice("identity:share=0.5", all);
  const Correspondences correspondences = synth::noise_study_problem({.correspondences = 40}).correspondences();
  EXPECT_EQ(register_by_choice(choice, correspondences, {.noise_bound = 3.0}).inliers.size(), 20u);
  EXPECT_EQ(choice.label(), "identity:share=0.5");
  EXPECT_EQ(solver_names(all).back(), "identity");
  EXPECT_NE(message_of(std::string("identity")).find("solver is 'identity'"), std::string::npos);
}

}  // namespace
}  // namespace consimd::test
