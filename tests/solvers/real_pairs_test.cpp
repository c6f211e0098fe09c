// Real pairs: correspondences/<case>/{correspondences.txt, pose.txt, case.json} in the folder CONSIMD_TEST_DATA.
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/problem_files.hpp>

#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

/// Inliers of a pair from which its pose must be found.
constexpr int kToldFromStructure = 20;

class RealPairs : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Solvers, RealPairs, ::testing::Values("tcf", "pcr99", "sc2_pcr", "turboreg"),
                         [](const auto& test) { return test.param; });

TEST_P(RealPairs, AreRegisteredWithinTheirLimits) {
  const char* data = std::getenv("CONSIMD_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "set CONSIMD_TEST_DATA to the folder with correspondences/<case>/";
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / "correspondences")) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::ranges::sort(folders);
  ASSERT_FALSE(folders.empty());
  for (const std::filesystem::path& folder : folders) {
    SCOPED_TRACE(folder.filename().string());
    std::ifstream file(folder / "case.json");
    const nlohmann::json limits = nlohmann::json::parse(file);
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
      const double rotation = synth::rotation_error_deg(result.T_target_source, problem.T_target_source);
      const double translation = synth::translation_error(result.T_target_source, problem.T_target_source);
      if (result.status == Status::success && rotation < limits.at("max_rotation_error_deg").get<double>() &&
          translation < limits.at("max_translation_error_m").get<double>()) {
        ++within;
      }
    }
    // Scans of different places give a pose a dozen and a half supporters as well.
    if (limits.at("inliers_within_noise_bound").get<int>() < kToldFromStructure) continue;
    EXPECT_GE(within + 1, seeds);
  }
}

}  // namespace
}  // namespace consimd::test
