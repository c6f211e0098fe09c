#include <consimd/synth/problem_files.hpp>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <consimd/synth/hard_problems.hpp>

namespace consimd::synth {
namespace {

namespace fs = std::filesystem;

/// A fresh folder of this test's own.
class ProblemFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("consimd_problem_files_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::set<std::string> names() const {
    std::set<std::string> result;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) result.insert(entry.path().filename());
    return result;
  }

  fs::path folder_;
};

/// All numbers of a file, '#' lines left out.
std::vector<double> numbers(const fs::path& path) {
  std::ifstream stream(path);
  std::vector<double> result;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream fields(line);
    for (std::string field; fields >> field;) result.push_back(std::stod(field));
  }
  return result;
}

std::string write_error(const Problem& problem, const fs::path& folder) {
  try {
    write_problem(problem, folder);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(ProblemFiles, ReadBackBitForBit) {
  const Problem problem = hard_problem(
      {.correspondences = 123, .outlier_ratio = 0.5, .source_offset = {5e6, 1e-7, 0}, .units_per_metre = 1.1});
  write_problem(problem, folder_ / "made" / "on demand");
  const fs::path written = folder_ / "made" / "on demand";

  std::vector<double> rows;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    rows.insert(rows.end(), &problem.source[3 * k], &problem.source[3 * k] + 3);
    rows.insert(rows.end(), &problem.target[3 * k], &problem.target[3 * k] + 3);
  }
  EXPECT_EQ(numbers(written / "correspondences.txt"), rows);

  std::vector<double> pose;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) pose.push_back(problem.T_target_source.matrix()(row, column));
  }
  EXPECT_EQ(numbers(written / "pose.txt"), pose);
  EXPECT_EQ(std::vector<double>(pose.end() - 4, pose.end()), (std::vector<double>{0, 0, 0, 1}));

  EXPECT_EQ(numbers(written / "labels.txt"), std::vector<double>(problem.is_inlier.begin(), problem.is_inlier.end()));
}

TEST_F(ProblemFiles, ReplaceEarlierOnesAndLeaveNothingElse) {
  write_problem(hard_problem({.correspondences = 50}), folder_);
  const Problem second = hard_problem({.correspondences = 20});
  write_problem(second, folder_);
  EXPECT_EQ(numbers(folder_ / "labels.txt").size(), 20u);
  EXPECT_EQ(names(), (std::set<std::string>{"case.json", "correspondences.txt", "labels.txt", "pose.txt"}));
}

TEST_F(ProblemFiles, FolderThatCannotBeMadeIsNamed) {
  std::ofstream(folder_ / "file") << "not a folder";
  const Problem problem = hard_problem({.correspondences = 3});
  EXPECT_NE(write_error(problem, folder_ / "file").find((folder_ / "file").string()), std::string::npos);
  EXPECT_NE(write_error(problem, folder_ / "file" / "sub").find((folder_ / "file" / "sub").string()),
            std::string::npos);
}

TEST_F(ProblemFiles, FailureLeavesTheOtherFilesAsTheyWere) {
  const Problem problem = hard_problem({.correspondences = 3});
  fs::create_directories(folder_ / "correspondences.txt" / "in the way");
  EXPECT_NE(write_error(problem, folder_).find((folder_ / "correspondences.txt").string()), std::string::npos);
  EXPECT_EQ(names(), (std::set<std::string>{"correspondences.txt"}));
}

}  // namespace
}  // namespace consimd::synth
