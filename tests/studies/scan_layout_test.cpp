#include <consimd/studies/scan_layout.hpp>

#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan_folders.hpp"

namespace consimd::studies {
namespace {

namespace fs = std::filesystem;
using consimd::test::TemporaryFolder;
using consimd::test::text_of;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// What a file holds, and what is said of it.
using Faults = std::vector<std::pair<std::string, std::string>>;

class ScanLayouts : public testing::Test {
 protected:
  [[nodiscard]] fs::path root() const { return folder_ / "data"; }

  [[nodiscard]] LayoutOptions options(const std::string& layout) const {
    return {.folder = root().string(), .layout = layout};
  }

  void expect_error(const LayoutOptions& options, const std::string& says, bool with_information = false) const {
    EXPECT_THAT([&] { static_cast<void>(read_scan_list(options, with_information)); },
                ThrowsMessage<std::exception>(HasSubstr(says)));
  }

  void replace(const std::string& file, const std::string& old, const std::string& with) const {
    std::string text = text_of(root() / file);
    const std::size_t place = text.find(old);
    ASSERT_NE(place, std::string::npos) << file << ": " << old;
    write_text(root() / file, text.replace(place, old.size(), with));
  }

  static void write_text(const fs::path& path, const std::string& text) { consimd::test::write_text(path, text); }

  TemporaryFolder folder_;
};

std::vector<std::string> names(const ScanGroup& group) {
  std::vector<std::string> found;
  found.reserve(group.pairs.size());
  for (const ScanPair& pair : group.pairs) found.push_back(pair.name);
  return found;
}

void expect_pose(const RigidTransform& found, const RigidTransform& expected) {
  EXPECT_LT((found.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_F(ScanLayouts, KittiPosesAreThoseOfTheScanner) {
  test::write_kitti(root());
  LayoutOptions kitti = options("kitti");
  kitti.distance = 3.0;
  const ScanList list = read_scan_list(kitti);
  ASSERT_EQ(list.groups.size(), 1U);
  const ScanGroup& group = list.groups.front();
  EXPECT_EQ(group.name, "KITTI 03");
  EXPECT_EQ(group.dataset, "KITTI");
  EXPECT_EQ(names(group), (std::vector<std::string>{"000001-000000", "000002-000001"}));
  const ScanPair& pair = group.pairs.back();
  EXPECT_EQ(pair.source.filename(), "000002.bin");
  EXPECT_EQ(pair.target.filename(), "000001.bin");
  expect_pose(pair.T_target_source, test::between(2, 1));
  EXPECT_EQ(pair.limits, (PoseLimits{5.0, 1.0}));
  EXPECT_THAT(list.notes, testing::ElementsAre("sequence 03 has 2 pairs at 3 m, not 200"));
}

TEST_F(ScanLayouts, KittiPairsAreDrawnBySeedAndDistance) {
  test::write_kitti(root());
  LayoutOptions kitti = options("kitti");
  kitti.distance = 6.2;  // 6.01 is nearer than a tenth, 3 is not
  EXPECT_EQ(names(read_scan_list(kitti).groups[0]), (std::vector<std::string>{"000002-000000"}));
  kitti.distance = 17.0;
  expect_error(kitti,
               "sequences/03/velodyne: no two of its 3 scans are 17 m apart, within a tenth; they are 3.0 to 6.0");
  kitti.distance = 3.0;
  kitti.pairs = 1;
  std::set<std::string> drawn;
  for (kitti.seed = 1; kitti.seed < 20; ++kitti.seed) {
    const ScanList list = read_scan_list(kitti);
    ASSERT_EQ(list.groups[0].pairs.size(), 1U);
    EXPECT_EQ(names(list.groups[0]), names(read_scan_list(kitti).groups[0]));
    drawn.insert(list.groups[0].pairs[0].name);
  }
  EXPECT_EQ(drawn.size(), 2U);
}

TEST_F(ScanLayouts, KittiTellsOfFramesWithoutScans) {
  test::write_kitti(root());
  fs::remove(root() / "sequences/03/velodyne/000001.bin");
  LayoutOptions kitti = options("kitti");
  kitti.distance = 6.0;
  const ScanList list = read_scan_list(kitti);
  EXPECT_EQ(names(list.groups[0]), (std::vector<std::string>{"000002-000000"}));
  EXPECT_THAT(list.notes.front(), HasSubstr("1 of the 3 frames of sequence 03 have no scan, the first is 000001"));
}

TEST_F(ScanLayouts, KittiPairsMayBeListed) {
  test::write_kitti(root() / "dataset");
  test::write_kitti(root() / "dataset", "12");
  const fs::path file = root() / "list.txt";
  write_text(file, "# sequence source target\n12, 0, 2\n03 1 0\n03\t2 0\n");
  LayoutOptions kitti = options("kitti");
  kitti.pair_list = file.string();
  const ScanList list = read_scan_list(kitti);
  ASSERT_EQ(list.groups.size(), 2U);
  EXPECT_EQ(names(list.groups[0]), (std::vector<std::string>{"000001-000000", "000002-000000"}));
  EXPECT_EQ(names(list.groups[1]), (std::vector<std::string>{"000000-000002"}));
  expect_pose(list.groups[1].pairs[0].T_target_source, test::between(0, 2));
  kitti.sequences = {"12"};
  EXPECT_EQ(read_scan_list(kitti).groups.size(), 1U);
  kitti.sequences = {};
  for (const auto& [line, says] : Faults{{"03 1", "list.txt:1: expected 3 values, got 2"},
                                         {"03 1 x", "list.txt:1: expected a whole number, got 'x'"},
                                         {"03 1 1", "list.txt:1: source and target are one scan"},
                                         {"03 1 7", "velodyne/000007.bin: is missing"},
                                         {"04 1 0", "sequences/04: is missing"},
                                         {"", "list.txt: lists no pairs"}}) {
    write_text(file, line);
    expect_error(kitti, says);
  }
  kitti.distance = 3.0;
  expect_error(kitti, "distance: a pair list tells which pairs there are");
}

TEST_F(ScanLayouts, KittiNamesWhatIsMissingOrWrong) {
  LayoutOptions kitti = options("kitti");
  kitti.distance = 3.0;
  expect_error(kitti, "data: no such folder");
  fs::create_directories(root());
  expect_error(kitti, "data/sequences: is missing");
  fs::create_directories(root() / "sequences");
  expect_error(kitti, "data/sequences: holds no sequence with poses");
  test::write_kitti(root());
  kitti.sequences = {"04"};
  expect_error(kitti, "data: has no sequence, scene or group '04'");
  kitti.sequences = {};
  replace("sequences/03/calib.txt", "Tr:", "Sr:");
  expect_error(kitti, "calib.txt: has no line 'Tr:'");
  write_text(root() / "sequences/03/calib.txt", "Tr: 1 0 0 0 0 1 0 0 0 0 2 0\n");
  expect_error(kitti, "calib.txt:1: not a rotation");
  write_text(root() / "sequences/03/calib.txt", "Tr: 1 0 0\n");
  expect_error(kitti, "calib.txt:1: expected a pose of 12 or 16 numbers, got 3");
  fs::remove(root() / "sequences/03/calib.txt");
  expect_error(kitti, "sequences/03/calib.txt: is missing");
  test::write_kitti(root());
  const std::string poses = text_of(root() / "poses/03.txt");
  write_text(root() / "poses/03.txt", poses.substr(0, poses.find('\n') + 1));
  expect_error(kitti, "poses/03.txt: has no pose of frame 2: it ends with frame 0");
  write_text(root() / "poses/03.txt", "1 0 0 0 0 1 0 0 0 0 nan 0\n");
  expect_error(kitti, "poses/03.txt:1: expected a finite number, got 'nan'");
  fs::remove(root() / "poses/03.txt");
  expect_error(kitti, "poses/03.txt: is missing");
  write_text(root() / "sequences/03/poses.txt", poses);  // where others keep them
  EXPECT_EQ(read_scan_list(kitti).groups[0].pairs.size(), 2U);
  fs::remove_all(root() / "sequences/03/velodyne");
  expect_error(kitti, "sequences/03/velodyne: is missing");
  fs::create_directories(root() / "sequences/03/velodyne");
  expect_error(kitti, "sequences/03/velodyne: holds no scan NNNNNN.bin");
}

TEST_F(ScanLayouts, KittiSequencesWithoutPublishedPosesAreLeftOut) {
  test::write_kitti(root());
  test::write_kitti(root(), "11");
  fs::remove(root() / "poses/11.txt");
  LayoutOptions kitti = options("kitti");
  kitti.distance = 3.0;
  const ScanList list = read_scan_list(kitti);
  EXPECT_EQ(list.groups.size(), 1U);
  EXPECT_THAT(list.notes.back(), HasSubstr("1 sequence after 10 left out"));
  kitti.sequences = {"11"};
  expect_error(kitti, "poses/11.txt: is missing");
}

TEST_F(ScanLayouts, EthPairsAreThePoseFiles) {
  test::write_eth(root());
  ScanList list = read_scan_list(options("eth"));
  ASSERT_EQ(list.groups.size(), 1U);
  EXPECT_EQ(list.groups[0].name, "ETH hall");
  EXPECT_EQ(names(list.groups[0]), (std::vector<std::string>{"s1-s0", "s2-s1"}));
  EXPECT_EQ(list.groups[0].pairs[0].source.filename(), "s1_v0.1.ply");
  expect_pose(list.groups[0].pairs[1].T_target_source, test::between(2, 1));
  EXPECT_EQ(list.groups[0].pairs[0].limits, (PoseLimits{5.0, 0.5}));
  LayoutOptions one = options("eth");
  one.folder = (root() / "hall").string() + "/";
  list = read_scan_list(one);
  EXPECT_EQ(list.groups[0].name, "ETH hall");

  write_text(root() / "hall/s1_other.ply", "x");
  expect_error(options("eth"), "hall: s1_other.ply and s1_v0.1.ply may both be scan s1");
  for (const char* name : {"s1_other.ply", "s1_v0.1.ply"}) fs::remove(root() / "hall" / name);
  expect_error(options("eth"), "hall/s1.EXT: is missing, which s1-s0.pose names");
  write_text(root() / "hall/s1-s0.pose", "1 0 0 0\n");
  expect_error(options("eth"), "s1-s0.pose: expected 3 or 4 rows, got 1");
  for (const char* name : {"s1-s0.pose", "s2-s1.pose"}) fs::remove(root() / "hall" / name);
  expect_error(options("eth"), "hall/SOURCE-TARGET.pose: is missing");
  fs::remove_all(root() / "hall");
  expect_error(options("eth"), "data: holds no scene");
}

TEST_F(ScanLayouts, FragmentsComeWithTheirPosesAndOverlaps) {
  test::write_3dmatch(root());
  LayoutOptions match = options("3dmatch");
  ScanList list = read_scan_list(match, true);
  ASSERT_EQ(list.groups.size(), 1U);
  EXPECT_EQ(list.groups[0].name, "kitchen");
  EXPECT_EQ(names(list.groups[0]), (std::vector<std::string>{"1-0", "2-0", "2-1"}));
  const ScanPair& pair = list.groups[0].pairs[1];
  EXPECT_EQ(pair.source.filename(), "cloud_bin_2.ply");
  expect_pose(pair.T_target_source, test::between(2, 0));
  EXPECT_EQ(pair.limits, (PoseLimits{15.0, 0.3}));
  EXPECT_EQ(pair.information->front(), 1000.0);
  EXPECT_EQ(pair.information->back(), 4000.0);
  match.skip_consecutive = true;
  EXPECT_EQ(names(read_scan_list(match).groups[0]), (std::vector<std::string>{"2-0"}));
  match.skip_consecutive = false;
  match.overlap = {0.1, 0.3};
  EXPECT_EQ(names(read_scan_list(match).groups[0]), (std::vector<std::string>{"2-0", "2-1"}));
  match.overlap = {0.8, 1.0};
  expect_error(match, "data: no pair has that overlap");

  // As 3DLoMatch is given: lists apart from the fragments.
  match.overlap.reset();
  fs::create_directories(folder_ / "benchmarks/kitchen");
  fs::rename(root() / "kitchen-evaluation/gt.log", folder_ / "benchmarks/kitchen/gt.log");
  expect_error(match, "data/kitchen/gt.log: is missing");
  match.ground_truth = (folder_ / "benchmarks").string();
  EXPECT_EQ(read_scan_list(match).groups[0].pairs.size(), 3U);
  expect_error(match, "benchmarks/kitchen/gt.info: is missing", true);
}

TEST_F(ScanLayouts, FragmentsNameWhatIsMissingOrWrong) {
  test::write_3dmatch(root());
  const LayoutOptions match = options("3dmatch");
  LayoutOptions low = match;
  low.overlap = {0.1, 0.3};
  replace("kitchen-evaluation/gt_overlap.log", "0,2,0.2\n", "");
  expect_error(low, "gt_overlap.log: has no overlap of fragments 0 and 2");
  replace("kitchen-evaluation/gt_overlap.log", "0,1,0.7", "0,1");
  expect_error(low, "gt_overlap.log:1: expected 3 values, got 2");
  fs::remove(root() / "kitchen-evaluation/gt_overlap.log");
  expect_error(low, "gt_overlap.log: is missing");
  replace("kitchen-evaluation/gt.info", "0\t2\t3", "0\t7\t3");
  expect_error(match, "gt.info: has no matrix of fragments 0 and 2", true);
  replace("kitchen-evaluation/gt.info", "1000 0", "0 0");
  expect_error(match, "gt.info:1: expected a number of points above 0", true);
  fs::remove(root() / "kitchen/cloud_bin_2.ply");
  expect_error(match, "kitchen/cloud_bin_2.ply: is missing, which gt.log names");
  write_text(root() / "kitchen/cloud_bin_2.ply", "");
  const std::string log = text_of(root() / "kitchen-evaluation/gt.log");
  write_text(root() / "kitchen-evaluation/gt.log", log.substr(0, log.size() - 10));
  expect_error(match, "gt.log:11: expected 4 lines after this one");
  write_text(root() / "kitchen-evaluation/gt.log", "0 1 3\n1 0 0 0\n");
  expect_error(match, "gt.log:1: expected 4 lines after this one");
  write_text(root() / "kitchen-evaluation/gt.log", "");
  expect_error(match, "kitchen has no pairs");
}

TEST_F(ScanLayouts, PairsAreATable) {
  test::write_pairs(root());
  ScanList list = read_scan_list(options("pairs"));
  ASSERT_EQ(list.groups.size(), 2U);
  EXPECT_EQ(list.groups[0].name, "one");
  EXPECT_EQ(names(list.groups[1]), (std::vector<std::string>{"2-1"}));
  expect_pose(list.groups[0].pairs[0].T_target_source, test::between(1, 0));
  expect_pose(list.groups[1].pairs[0].T_target_source, test::between(2, 1));
  EXPECT_FALSE(list.groups[0].pairs[0].limits);

  LayoutOptions file = options("pairs");
  file.folder += "/pairs.csv";
  file.sequences = {"two"};
  EXPECT_EQ(read_scan_list(file).groups.size(), 1U);
  file.sequences = {"two", "two"};
  expect_error(file, "sequences: two is given twice");

  write_text(root() / "pairs.csv", "a/1.ply, a/0.ply, a/pose.txt\n");
  list = read_scan_list(options("pairs"));
  EXPECT_EQ(list.groups[0].name, "data");
  write_text(root() / "pairs.csv",
             "pose;source;target;name;max_rotation_error_deg;max_translation_error_m\n"
             "a/pose.txt;a/1.ply;a/0.ply;first;2;0.1\na/pose.txt;a/1.ply;a/0.ply;second;;\n");
  list = read_scan_list(options("pairs"));
  EXPECT_EQ(names(list.groups[0]), (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(list.groups[0].pairs[0].limits, (PoseLimits{2.0, 0.1}));
  EXPECT_FALSE(list.groups[0].pairs[1].limits);
}

TEST_F(ScanLayouts, PairsNameWhatIsMissingOrWrong) {
  test::write_pairs(root());
  const LayoutOptions pairs = options("pairs");
  for (const auto& [text, says] : Faults{
           {"source,target\na,b\n", "pairs.csv:1: has no column 'pose'"},
           {"source,target,pose,colour\na,b,c,d\n", "pairs.csv:1: unknown column 'colour'"},
           {"source,target,pose,pose\na,b,c,d\n", "pairs.csv:1: column 'pose' is there twice"},
           {"source,target,pose\na/1.ply,a/9.ply,a/pose.txt\n", "a/9.ply: is missing"},
           {"source,target,pose\na/1.ply,,a/pose.txt\n", "pairs.csv:2: has no target"},
           {"source,target,pose\na/1.ply,a/0.ply,a/none.txt\n", "a/none.txt: is missing"},
           {"source,target,pose\na/1.ply,a/0.ply,1 0 0\n", "pairs.csv:2: expected a pose of 12 or 16 numbers, got 3"},
           {"source,target,pose\na/1.ply,a/0.ply,1 0 0 0 0 1 0 0 0 0 -1 0\n", "pairs.csv:2: not a rotation"},
           {"source,target,pose\na/1.ply,a/0.ply\n", "pairs.csv:2: expected 3 values, got 2"},
           {"a/1.ply,a/0.ply,a/pose.txt\na/1.ply,a/0.ply,a/pose.txt\n", "pairs.csv:2: pair 1-0 is there twice"},
           {"source,target,pose,max_rotation_error_deg\na/1.ply,a/0.ply,a/pose.txt,5\n", "limits of both"},
           {"source,target,pose,max_rotation_error_deg\na/1.ply,a/0.ply,a/pose.txt,-5\n", "expected a number above 0"},
           {"source,target,pose\n", "pairs.csv: lists no pairs"},
           {"", "pairs.csv: lists no pairs"}}) {
    write_text(root() / "pairs.csv", text);
    expect_error(pairs, says);
  }
  fs::remove(root() / "pairs.csv");
  expect_error(pairs, "data/pairs.csv: is missing");
}

TEST_F(ScanLayouts, RefuseBadOptions) {
  test::write_kitti(root());
  const auto changed = [&](const std::string& layout, const auto& change) {
    LayoutOptions bad = options(layout);
    change(bad);
    return bad;
  };
  expect_error(options(""), "layout: of scans it is needed: one of kitti, eth, 3dmatch, pairs");
  expect_error(options("moon"), "layout: 'moon' is none of kitti, eth, 3dmatch, pairs");
  expect_error(changed("kitti", [](auto& o) { o.pairs = 0; }), "pairs: expected at least 1");
  expect_error(changed("kitti", [](auto& o) { o.distance = -1.0; }), "distance: expected a length above 0, got -1");
  expect_error(changed("kitti", [](auto& o) { o.overlap = {0.1, 0.3}; }), "overlap: it is for the layout 3dmatch");
  expect_error(changed("kitti", [](auto& o) { o.skip_consecutive = true; }), "skip consecutive: it is for the layout");
  expect_error(changed("kitti", [](auto& o) { o.ground_truth = "x"; }), "ground truth: it is for the layout 3dmatch");
  expect_error(changed("eth", [](auto& o) { o.distance = 3.0; }), "distance: it is for the layout kitti, not eth");
  expect_error(changed("eth", [](auto& o) { o.pair_list = "x"; }), "pair list: it is for the layout kitti");
  expect_error(changed("3dmatch", [](auto& o) { o.overlap = {0.3, 0.1}; }), "overlap: expected two shares in [0, 1]");
  EXPECT_THROW((void)layout_front_end("moon"), std::invalid_argument);
  EXPECT_EQ(layout_front_end("kitti").voxel, 0.3);
  EXPECT_TRUE(layout_front_end("eth").iss);
}

}  // namespace
}  // namespace consimd::studies
