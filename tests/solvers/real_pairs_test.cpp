// Real pairs: <set>/<case>/{correspondences.txt, pose.txt, case.json} in the folder CONSIMD_TEST_DATA, where <set> is
// correspondences or hard_pairs.
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/problem_files.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pose_errors.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

/// Inliers of a pair from which its pose must be found.
constexpr int kToldFromStructure = 20;

constexpr const char* kNoData =
    "set CONSIMD_TEST_DATA to the folder with correspondences/<case>/ and hard_pairs/<case>/";

/// Sorted; empty without CONSIMD_TEST_DATA.
std::vector<std::filesystem::path> cases_of(const char* set) {
  std::vector<std::filesystem::path> folders;
  const char* data = std::getenv("CONSIMD_TEST_DATA");
  if (data == nullptr) return folders;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / set)) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::ranges::sort(folders);
  EXPECT_FALSE(folders.empty());
  return folders;
}

nlohmann::json limits_of(const std::filesystem::path& folder) {
  std::ifstream file(folder / "case.json");
  return nlohmann::json::parse(file);
}

bool is_within(const nlohmann::json& limits, const Registration& result, const Problem& problem) {
  return synth::rotation_error_deg(result.T_target_source, problem.T_target_source) <
             limits.at("max_rotation_error_deg").get<double>() &&
         synth::translation_error(result.T_target_source, problem.T_target_source) <
             limits.at("max_translation_error_m").get<double>();
}

class RealPairs : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Solvers, RealPairs, ::testing::Values("tcf", "pcr99", "sc2_pcr", "turboreg"),
                         [](const auto& test) { return test.param; });

TEST_P(RealPairs, AreRegisteredWithinTheirLimits) {
  const std::vector<std::filesystem::path> folders = cases_of("correspondences");
  if (folders.empty()) GTEST_SKIP() << kNoData;
  for (const std::filesystem::path& folder : folders) {
    SCOPED_TRACE(folder.filename().string());
    const nlohmann::json limits = limits_of(folder);
    const double noise_bound = limits.at("noise_bound").get<double>();
    const Problem problem = synth::read_problem(folder / "correspondences.txt", folder / "pose.txt", noise_bound);
    ASSERT_EQ(problem.size(), limits.at("correspondences").get<std::size_t>());
    const Correspondences correspondences = problem.correspondences();
    const std::uint64_t seeds = trials(5);
    std::uint64_t within = 0;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed);
      const Registration result =
          register_by_name(GetParam(), correspondences, {.noise_bound = noise_bound, .seed = seed});
      expect_sound(result, problem, noise_bound);
      if (result.status == Status::success && is_within(limits, result, problem)) ++within;
    }
    // Scans of different places give a pose a dozen and a half supporters as well.
    if (limits.at("inliers_within_noise_bound").get<int>() < kToldFromStructure) continue;
    EXPECT_GE(within + 1, seeds);
  }
}

// A hundred supporters in a dozen places: where they are counted, and by which search a pose is met, decides.
TEST(RealPairsInDoubt, AreWorthTheSameWhateverTheSeed) {
  constexpr double kNoise = 0.05;
  for (const std::filesystem::path& folder : cases_of("hard_pairs")) {
    const std::string name = folder.filename().string();
    if (name != "3dlomatch_redkitchen_34_21_top3" && name != "3dlomatch_redkitchen_7_1_nn") continue;
    SCOPED_TRACE(name);
    const nlohmann::json limits = limits_of(folder);
    const double noise_bound = limits.at("noise_bound").get<double>();
    const Problem problem = synth::read_problem(folder / "correspondences.txt", folder / "pose.txt", noise_bound);
    const Correspondences correspondences = problem.correspondences();
    double least = 0.0;
    double most = -kInfinity;
    for (std::uint64_t seed = 1; seed <= trials(6); ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed);
      const Registration result = register_by_name("tcf", correspondences, {.noise_bound = noise_bound, .seed = seed});
      EXPECT_EQ(result.status, Status::success);
      EXPECT_TRUE(is_within(limits, result, problem));
      least = std::min(least, result.log10_false_poses);
      most = std::max(most, result.log10_false_poses);
    }
    EXPECT_LT(most - least, std::log10(2.0) + kNoise);  // met by the second search, it counts twice
  }
  if (cases_of("hard_pairs").empty()) GTEST_SKIP() << kNoData;
}

TEST(RealPairsCovariance, ErrorsAreAboutAsLargeAsItSays) {
  const std::vector<std::filesystem::path> folders = cases_of("hard_pairs");
  if (folders.empty()) GTEST_SKIP() << kNoData;
  NormalisedErrors errors;
  for (const std::filesystem::path& folder : folders) {
    SCOPED_TRACE(folder.filename().string());
    const nlohmann::json limits = limits_of(folder);
    const double noise_bound = limits.at("noise_bound").get<double>();
    const Problem problem = synth::read_problem(folder / "correspondences.txt", folder / "pose.txt", noise_bound);
    const Registration result = register_by_name("tcf", problem.correspondences(), {.noise_bound = noise_bound});
    if (!result.has_pose() || !is_within(limits, result, problem)) continue;
    errors.add(result.T_target_source, problem.T_target_source, result.covariance);
  }
  ASSERT_GE(2 * errors.of_trials.size(), folders.size());
  // The median of a chi-square variable of six degrees of freedom is 5.35. References have errors as well.
  EXPECT_GT(errors.median_nees(), 3.0);
  EXPECT_LT(errors.median_nees(), 12.0);
}

}  // namespace
}  // namespace consimd::test
