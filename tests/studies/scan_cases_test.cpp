#include <consimd/studies/scan_cases.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <consimd/features/cloud_files.hpp>
#include <consimd/features/register_clouds.hpp>
#include <consimd/synth/metrics.hpp>

#include <consimd/studies/case_folder.hpp>
#include <consimd/studies/compare_options.hpp>
#include <consimd/studies/comparison_folder.hpp>
#include <consimd/studies/comparison_merge.hpp>
#include <consimd/studies/method.hpp>
#include "scan_folders.hpp"
#include "small_comparison.hpp"

namespace consimd::studies {
namespace {

namespace fs = std::filesystem;
using consimd::test::TemporaryFolder;
using consimd::test::text_of;
using consimd::test::write_text;
using testing::HasSubstr;
using testing::ThrowsMessage;

ScanOptions kitti_options(const fs::path& root) {
  ScanOptions options{.layout = {.folder = root.string(), .layout = "kitti", .distance = 3.0},
                      .front_end = layout_front_end("kitti")};
  options.front_end.voxel = 0.25;
  return options;
}

TEST(ScanCases, HaveTheMatchesOfTheirScans) {
  const TemporaryFolder folder;
  test::write_kitti(folder / "k");
  const ScanGroups found = scan_groups(kitti_options(folder / "k"), "case");
  ASSERT_EQ(found.groups.size(), 1U);
  ASSERT_EQ(found.groups[0].cases.size(), 2U);
  const Case& one = found.groups[0].cases[0];
  const CaseData data = one.load();
  const Cloud source = features::read_cloud(folder / "k/sequences/03/velodyne/000001.bin");
  const Cloud target = features::read_cloud(folder / "k/sequences/03/velodyne/000000.bin");
  const features::CloudMatches matches = features::match_clouds(source, target, {.voxel = 0.25});
  ASSERT_EQ(data.problem.size(), matches.matches.size());
  EXPECT_EQ(data.noise_bound, matches.noise_bound);
  for (std::size_t k = 0; k < matches.matches.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(data.problem.source[3 * k + c], matches.source_points[k][c]);
      EXPECT_EQ(data.problem.target[3 * k + c], matches.target_points[k][c]);
    }
  }
  EXPECT_GT(std::ranges::count(data.problem.is_inlier, 1), 20);
  EXPECT_NEAR(one.distance, std::hypot(3.0, 0.2), 1e-9);
}

TEST(ScanCases, KeptCorrespondencesHaveTheSameBits) {
  const TemporaryFolder folder;
  test::write_kitti(folder / "k");
  ScanOptions options = kitti_options(folder / "k");
  const CaseData made = scan_groups(options, "case").groups[0].cases[0].load();
  options.cache = folder / "kept";
  const auto load = [&] { return scan_groups(options, "case").groups[0].cases[0].load(); };
  const fs::path of_pair = folder / "kept/KITTI_03_000001-000000";
  for (const char* round : {"written", "read"}) {
    const CaseData kept = load();
    EXPECT_EQ(kept.problem.source, made.problem.source) << round;
    EXPECT_EQ(kept.problem.target, made.problem.target) << round;
    EXPECT_EQ(kept.problem.is_inlier, made.problem.is_inlier) << round;
    EXPECT_EQ(kept.problem.T_target_source.matrix(), made.problem.T_target_source.matrix()) << round;
    EXPECT_EQ(kept.noise_bound, made.noise_bound) << round;
    ASSERT_TRUE(fs::exists(of_pair / "case.json")) << round;
  }
  // They are read where they are of these scans and options, and made anew where not, or where they are damaged.
  const std::string text = text_of(of_pair / "correspondences.txt");
  std::string other = text;
  const std::size_t number = other.find('\n') + 1;  // of the other sign
  other[number] == '-' ? other.erase(number, 1) : other.insert(number, "-");
  write_text(of_pair / "correspondences.txt", other);
  EXPECT_NE(load().problem.source, made.problem.source);
  options.front_end.voxel = 0.3;
  EXPECT_NE(load().problem.size(), made.problem.size());
  options.front_end.voxel = 0.25;
  EXPECT_EQ(load().problem.source, made.problem.source);
  for (const char* file : {"correspondences.txt", "pose.txt", "case.json"}) {
    const std::string whole = text_of(of_pair / file);
    write_text(of_pair / file, whole.substr(0, whole.size() / 2));
    EXPECT_EQ(load().problem.source, made.problem.source) << file;
    EXPECT_EQ(text_of(of_pair / file), whole);
  }
  // The folder is one of cases.
  static_cast<void>(scan_groups(options, "case").groups[0].cases[1].load());
  const std::vector<CaseGroup> cases = case_folder_groups(folder / "kept", 1, "case");
  ASSERT_EQ(cases.size(), 1U);
  EXPECT_EQ(cases[0].name, "KITTI 03");
  EXPECT_EQ(cases[0].cases.size(), 2U);
  EXPECT_EQ(cases[0].cases[0].limits, (PoseLimits{5.0, 1.0}));
  EXPECT_EQ(cases[0].cases[0].load().problem.is_inlier, made.problem.is_inlier);
}

TEST(ScanCases, DigestsTellWhatTheyAreOf) {
  const TemporaryFolder folder;
  test::write_kitti(folder / "k");
  ScanOptions options = kitti_options(folder / "k");
  const auto digest = [&] { return scan_groups(options, "case").groups[0].cases[0].digest; };
  const std::string first = digest();
  EXPECT_EQ(digest(), first);
  std::set<std::string> others;
  options.front_end.matches.best = 2;
  others.insert(digest());
  options.front_end.matches.best = 3;
  options.noise_bound = 0.5;
  others.insert(digest());
  options.noise_bound.reset();
  options.layout.seed = 2;
  others.insert(digest());
  options.layout.seed = 1;
  write_text(folder / "k/sequences/03/velodyne/000000.bin", test::bin_of(test::room(99, test::place_of(0))));
  others.insert(digest());
  EXPECT_EQ(others.size(), 4U);
  EXPECT_FALSE(others.contains(first));
}

TEST(ScanCases, EveryScanIsReadBeforeAnythingRuns) {
  const TemporaryFolder folder;
  test::write_kitti(folder / "k");
  const ScanOptions options = kitti_options(folder / "k");
  const fs::path scan = folder / "k/sequences/03/velodyne/000002.bin";
  const auto read = [&] { static_cast<void>(scan_groups(options, "case")); };
  const std::string whole = text_of(scan);
  write_text(scan, whole.substr(0, whole.size() - 5));
  EXPECT_THAT(read, ThrowsMessage<std::runtime_error>(HasSubstr("000002.bin: ")));
  write_text(scan, "");
  EXPECT_THAT(read, ThrowsMessage<std::runtime_error>(HasSubstr("000002.bin: ")));
  write_text(scan, whole);
  std::size_t told = 0;
  static_cast<void>(scan_groups(options, "case", [&](std::size_t done, std::size_t all) {
    EXPECT_EQ(done, ++told);
    EXPECT_EQ(all, 3U);
  }));
  EXPECT_EQ(told, 3U);
  EXPECT_THROW((void)scan_groups(options, "case", [](std::size_t, std::size_t) { throw std::logic_error("enough"); }),
               std::logic_error);
}

TEST(ScanCases, RefuseBadOptions) {
  const TemporaryFolder folder;
  test::write_kitti(folder / "k");
  ScanOptions options = kitti_options(folder / "k");
  const auto read = [&](const std::string& preset) { return [&, preset] { (void)scan_groups(options, preset); }; };
  EXPECT_THAT(read("magic"), ThrowsMessage<std::invalid_argument>(HasSubstr("unknown thresholds 'magic'")));
  EXPECT_THAT(read("3dmatch-rmse"), ThrowsMessage<std::invalid_argument>(HasSubstr("needs the gt.info")));
  options.noise_bound = -1.0;
  EXPECT_THAT(read("case"), ThrowsMessage<std::invalid_argument>(HasSubstr("noise bound: expected a length above 0")));
  options.noise_bound.reset();
  options.front_end.voxel = 0.0;
  EXPECT_THAT(read("case"), ThrowsMessage<std::invalid_argument>(HasSubstr("voxel: expected a length above 0, got 0")));
}

TEST(ScanCases, DisplacementsDecideOverFragments) {
  const TemporaryFolder folder;
  test::write_3dmatch(folder / "m");
  const ScanOptions options{.layout = {.folder = (folder / "m").string(), .layout = "3dmatch"},
                            .front_end = {.voxel = 0.25}};
  std::vector<CaseGroup> groups = scan_groups(options, "3dmatch-rmse").groups;
  ASSERT_TRUE(groups[0].cases[0].displacement);
  EXPECT_FALSE(groups[0].cases[0].limits);
  const DisplacementLimit& limit = *groups[0].cases[0].displacement;
  EXPECT_EQ(limit.root_mean_square, 0.2);
  const RigidTransform truth = test::between(1, 0);
  const auto displaced = [&](const RigidTransform& error) {
    return root_mean_square_displacement(limit.information, truth * error, truth);
  };
  EXPECT_NEAR(displaced(test::moved(0.0, 0.3, 0.0, 0.0)), 0.3, 1e-9);
  EXPECT_NEAR(displaced(test::moved(0.1, 0.0, 0.0, 0.0)), 2.0 * std::sin(0.05), 1e-9);  // 4000 / 1000
  EXPECT_NEAR(displaced(RigidTransform::Identity()), 0.0, 1e-9);
  groups[0].methods = {"tcf"};
  Comparison comparison(groups, 1);
  run_comparison(comparison);
  for (const RunRecord& run : comparison.done()) {
    EXPECT_EQ(run.success, run.has_pose() && run.translation_error < 0.2) << run.case_name;
  }
}

TEST(ScanCases, ThePipelineIsRegisterClouds) {
  const TemporaryFolder folder;
  test::write_kitti(folder / "k");
  std::vector<CaseGroup> groups = scan_groups(kitti_options(folder / "k"), "case").groups;
  groups[0].methods = {from_scans("tcf")};
  Comparison comparison(groups, 2);
  run_comparison(comparison);
  const RunRecord run = comparison.done()[1];
  EXPECT_EQ(run.method, "scans+tcf");
  EXPECT_EQ(run.seed, 2U);
  const Cloud source = features::read_cloud(folder / "k/sequences/03/velodyne/000001.bin");
  const Cloud target = features::read_cloud(folder / "k/sequences/03/velodyne/000000.bin");
  const features::CloudRegistration found =
      features::register_clouds(source, target, {.matching = {.voxel = 0.25, .seed = 2}, .seed = 2});
  EXPECT_EQ(run.status, to_string(found.registration.status));
  EXPECT_EQ(run.kept, found.registration.inliers.size());
  EXPECT_EQ(run.rows, found.matches.matches.size());
  EXPECT_EQ(run.has_pose(), found.registration.has_pose());
  if (run.has_pose()) {
    EXPECT_EQ(run.rotation_error_deg, synth::rotation_error_deg(found.registration.T_target_source,
                                                                groups[0].cases[0].load().problem.T_target_source));
  }
}

CompareOptions small_options(const fs::path& root) {
  CompareOptions options;
  options.scans = kitti_options(root);
  options.tables.tables = {"data", "solvers", "pipeline"};
  options.tables.solvers = {"tcf", "ransac"};
  return options;
}

TEST(ScanCases, ComparisonsDoNotDependOnTheNumberOfThreads) {
  const TemporaryFolder folder;
  test::write_kitti(folder / "k");
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 3);
  const auto run = [&](int threads) {
    return tbb::task_arena(threads).execute([&] {
      Comparison comparison = make_comparison(small_options(folder / "k"));
      run_comparison(comparison);
      return timeless(comparison);
    });
  };
  const std::vector<std::string> one = run(1);
  EXPECT_EQ(one.size(), 10U);  // two pairs, 1R, two solvers and two pipelines
  EXPECT_EQ(run(3), one);
}

TEST(ScanCases, ShardsMergedEqualTheWhole) {
  const TemporaryFolder folder;
  test::write_kitti(folder / "k");
  const CompareOptions options = small_options(folder / "k");
  const ComparisonFacts facts{.options = option_texts(options), .isa = "scalar"};
  Comparison whole = make_comparison(options);
  run_comparison(whole);
  const ComparisonResults results = comparison_results(options.tables, whole);
  ComparisonFolder(folder / "whole", whole, facts, false).write(whole, results, facts);

  std::vector<fs::path> shards;
  for (const std::uint32_t index : {1U, 2U}) {
    Comparison part = make_comparison(options, Shard{index, 2});
    EXPECT_EQ(part.size(), whole.size() / 2);
    shards.push_back(folder / fmt::format("s/shard-{}-of-2", index));
    ComparisonFolder files(shards.back(), part, facts, false);
    const auto merge = [&] { static_cast<void>(merge_comparisons(shards)); };
    EXPECT_THAT(merge, ThrowsMessage<std::runtime_error>(
                           HasSubstr(index == 1 ? "missing: 2/2; unfinished: 1/2 in" : "unfinished: 2/2 in")));
    for (const RunRecord& run : whole.done()) {
      try {
        part.put(run);
      } catch (const std::invalid_argument&) {
        continue;  // of the other one
      }
    }
    EXPECT_TRUE(part.complete());
    files.write(part, {}, facts);
    EXPECT_FALSE(fs::exists(shards.back() / "tables.md"));
  }
  fs::remove_all(folder / "k");  // the data are not needed
  EXPECT_EQ(comparison_shards({folder / "s"}), shards);
  EXPECT_TRUE(comparison_shards({folder / "whole"}).empty());
  const MergedComparison merged = merge_comparisons({shards[1], shards[0]});
  write_comparison(folder / "merged", merged, comparison_results(merged.tables, merged.comparison), false);
  for (const char* file : {"runs.csv", "tables.md", "table_solvers.csv", "table_data.csv", "pairs.csv", "solvers.csv",
                           "curves.csv", "comparison.json"}) {
    EXPECT_EQ(text_of(folder / "merged" / file), text_of(folder / "whole" / file)) << file;
  }

  EXPECT_THAT(
      [&] {
        (void)merge_comparisons({shards[0], shards[0]});
      },
      ThrowsMessage<std::runtime_error>(HasSubstr("shard 1/2 is there twice")));
  EXPECT_THAT([&] { (void)merge_comparisons({folder / "whole"}); },
              ThrowsMessage<std::runtime_error>(HasSubstr("whole: not a shard of a comparison")));
  const fs::path summary = shards[1] / "comparison.json";
  const std::string text = text_of(summary);
  const auto changed = [&](const std::string& old, const std::string& with, const std::string& says) {
    std::string other = text;
    other.replace(other.find(old), old.size(), with);
    write_text(summary, other);
    EXPECT_THAT([&] { (void)merge_comparisons(shards); }, ThrowsMessage<std::runtime_error>(HasSubstr(says))) << old;
  };
  changed(R"("voxel": "0.25")", R"("voxel": "0.5")", "is of another comparison than");
  changed(R"("shard": "2/2")", R"("shard": "2/3")", "is one of 3 shards");
  changed(R"("shard": "2/2")", R"("shard": 5)", "bad shard");
  changed(R"({)", R"([)", "comparison.json: ");
}

}  // namespace
}  // namespace consimd::studies
