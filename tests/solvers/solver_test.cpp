#include <consimd/solvers/solver.hpp>

#include <consimd/solvers/tcf.hpp>
#include <consimd/solvers/tcf_published.hpp>
#include <consimd/synth/noise_study.hpp>

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

Problem easy_problem() { return synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.5}); }

TEST(Solver, ListStartsWithTheDefaultAndHasNoDoubles) {
  ASSERT_FALSE(solvers().empty());
  EXPECT_EQ(solvers().front().name, "tcf");
  std::set<std::string_view> names;
  const std::vector<std::string> all = solver_names();
  for (const std::string& name : all) {
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_FALSE(SolverChoice(name).description().empty()) << name;
  }
  EXPECT_TRUE(names.contains("tcf-published"));
  EXPECT_TRUE(names.contains("ransac-10k"));
}

TEST(Solver, UnknownNameThrowsAndListsTheKnownOnes) {
  const Correspondences correspondences = easy_problem().correspondences();
  for (const std::string name : {"", "TCF", "tcf ", "gc-ransac"}) {
    try {
      static_cast<void>(register_by_name(name, correspondences, {.noise_bound = 3.0}));
      ADD_FAILURE() << "'" << name << "' was accepted";
    } catch (const std::invalid_argument& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("'" + name + "'"), std::string::npos) << message;
      for (const std::string& known : solver_names()) EXPECT_NE(message.find(known), std::string::npos) << message;
    }
  }
}

TEST(Solver, EveryOneRejectsBadBounds) {
  const Correspondences correspondences = easy_problem().correspondences();
  const Correspondences nothing;
  for (const std::string& solver : solver_names()) {
    for (const double bound : kBadLengths) {
      const SolverOptions options{.noise_bound = bound};
      for (const Correspondences& input : {std::cref(correspondences), std::cref(nothing)}) {
        expect_rejected([&] { static_cast<void>(register_by_name(solver, input, options)); }, "noise_bound", bound);
      }
    }
  }
}

TEST(Solver, EveryOneNeedsNoBound) {
  const Problem problem = easy_problem();
  for (const std::string& solver : solver_names()) {
    const Registration result = register_by_name(solver, problem.correspondences(), {.noise_bound = std::nullopt});
    EXPECT_NEAR(result.noise_bound, 3.0, 0.6) << solver;
    expect_sound(result, problem, result.noise_bound);
    ASSERT_FALSE(result.stages.empty()) << solver;
    EXPECT_EQ(result.stages.front().name, "noise_bound") << solver;
  }
}

TEST(Solver, NameMeansTheFunction) {
  const Correspondences correspondences = easy_problem().correspondences();
  for (const auto& [name, direct] :
       {std::pair("tcf", register_tcf(correspondences, {.noise_bound = 3.0, .seed = 7})),
        std::pair("tcf-published", register_tcf_published(correspondences, {.noise_bound = 3.0, .seed = 7}))}) {
    const Registration by_name = register_by_name(name, correspondences, {.noise_bound = 3.0, .seed = 7});
    EXPECT_EQ(by_name.status, direct.status) << name;
    EXPECT_EQ(by_name.seed, 7u) << name;
    EXPECT_EQ(by_name.T_target_source.matrix(), direct.T_target_source.matrix()) << name;
    EXPECT_EQ(by_name.inliers, direct.inliers) << name;
    ASSERT_EQ(by_name.stages.size(), direct.stages.size()) << name;
    for (std::size_t s = 0; s < direct.stages.size(); ++s) {
      EXPECT_EQ(by_name.stages[s].iterations, direct.stages[s].iterations) << name;
    }
  }
}

TEST(Solver, OneOfTheCallersIsGivenTheEstimateAndTheFilteredRows) {
  const Problem problem = easy_problem();
  const Correspondences correspondences = problem.correspondences();
  for (const Filter filter : {Filter::none, Filter::tcf}) {
    for (const std::optional<double> bound : {std::optional<double>(3.0), std::optional<double>()}) {
      const SolverOptions options{.noise_bound = bound, .seed = 7, .filter = filter};
      const Registration by_name = register_by_name("tcf", correspondences, options);
      std::size_t rows_given = 0;
      const Registration with = register_with(
          [&](const Correspondences& rows, double noise_bound, std::uint32_t bounds_tried) {
            rows_given = rows.size();
            EXPECT_EQ(noise_bound, by_name.noise_bound);
            EXPECT_EQ(bounds_tried > 1, !bound.has_value());
            return register_tcf(rows, {.noise_bound = noise_bound, .seed = 7, .bounds_tried = bounds_tried});
          },
          correspondences, options);
      EXPECT_EQ(rows_given < correspondences.size(), filter == Filter::tcf);
      EXPECT_EQ(with.T_target_source.matrix(), by_name.T_target_source.matrix());
      EXPECT_EQ(with.inliers, by_name.inliers);
      EXPECT_EQ(with.stages.size(), by_name.stages.size());
    }
  }
}

TEST(Solver, StatusesHaveNames) {
  std::set<std::string_view> names;
  for (const Status status : {Status::success, Status::too_few_correspondences, Status::no_consensus,
                              Status::degenerate_geometry, Status::ambiguous, Status::budget_exhausted}) {
    EXPECT_TRUE(names.insert(to_string(status)).second);
  }
  EXPECT_EQ(to_string(Status::success), "success");
  EXPECT_EQ(to_string(Status::ambiguous), "ambiguous");
}

}  // namespace
}  // namespace consimd::test
