#include <consimd/synth/problem_files.hpp>

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <consimd/synth/noise_study.hpp>
#include "temporary_folder.hpp"

namespace consimd::synth {
namespace {

class PoseReadingTest : public testing::Test {
 protected:
  RigidTransform read(const std::string& text) {
    test::write_text(folder_ / "pose.txt", text);
    return read_pose(folder_ / "pose.txt");
  }
  test::TemporaryFolder folder_;
};

constexpr const char* kQuarterTurn = "0 -1 0 5\n1 0 0 6\n0 0 1 7\n";

TEST_F(PoseReadingTest, ReadsThreeAndFourRows) {
  for (const std::string& text : {std::string(kQuarterTurn), kQuarterTurn + std::string("0 0 0 1\n")}) {
    const Eigen::Vector3d moved = read(text) * Eigen::Vector3d(1, 0, 0);
    EXPECT_TRUE(moved.isApprox(Eigen::Vector3d(5, 7, 7))) << moved.transpose();
  }
}

TEST_F(PoseReadingTest, ReadsTheFormsOfTrajectories) {
  const RigidTransform expected = read(kQuarterTurn);
  for (const char* text : {
           "0 -1 0 5 1 0 0 6 0 0 1 7\n",                                      // KITTI
           "0,-1,0,5,1,0,0,6,0,0,1,7,0,0,0,1\n",                              // the same with its last row
           "0 1 2\n0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n",                    // gt.log
           "# t x y z qx qy qz qw\n1.5e9 5 6 7 0 0 0.70710678 0.70710678\n",  // TUM
           "5 6 7 0 0 -0.70710678 -0.70710678\n",
       }) {
    EXPECT_TRUE(read(text).isApprox(expected, 1e-7)) << text;
  }
}

TEST_F(PoseReadingTest, RefusesSeveralPosesAndBadOnes) {
  const std::string kitti = "0 -1 0 5 1 0 0 6 0 0 1 7\n", logged = "0 1 2\n0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n";
  const auto refused = [this](const std::string& text, const std::string& says) {
    const auto reading = [&] { (void)read(text); };
    EXPECT_THAT(reading, testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr(says))) << text;
  };
  refused(kitti + kitti + kitti, "3 poses, expected the one of the pair");
  refused(logged + logged, "2 poses, expected the one of the pair");
  refused("0 5 6 7 0 0 0.5 0.5\n", "a quaternion of length 0.707");
  refused("0 5 6 7 0 0 0 0\n", "a quaternion of length 0");
  refused(kitti.substr(0, kitti.size() - 3) + "\n", "1: expected 4 numbers, got 11");
  refused("0 -1 0 5 1 0 0 6 0 0 1 7 0 0 1 1\n", "the last row must be 0 0 0 1");
  refused("a b c d\n" + kitti, "a line of names, expected a pose");
  refused("", "pose.txt: is empty, expected lines of numbers");
  refused("1 0 0 0\n0 1 0 0\n", "expected 3 or 4 rows, got 2: write the matrix [R t], 3 or 4 rows of 4 numbers");
  refused("1\n0\n0\n0\n", "1: expected 4 numbers, got 1: write the matrix [R t]");
  refused("0 -1 0 5,5\n1 0 0 6\n0 0 1 7\n", "pose.txt:1: '5,5' has a decimal comma: write decimal points");
  refused("0,0 -1,0 0,0 5,5\n1,0 0,0 0,0 6,0\n0,0 0,0 1,0 7,0\n", "pose.txt:1: '0,0' has a decimal comma");
  refused("1,5 6 7 0 0 0,6 0,8\n", "pose.txt:1: '1,5' has a decimal comma");
}

TEST_F(PoseReadingTest, TakesALastRowThatIsOffByRounding) {
  EXPECT_TRUE(read(kQuarterTurn + std::string("1e-17 -2.3e-16 0 0.9999999999999998\n"))
                  .linear()
                  .isApprox(read(kQuarterTurn).linear()));
  EXPECT_THROW((void)read(kQuarterTurn + std::string("0 0 1e-5 1\n")), std::runtime_error);
}

TEST_F(PoseReadingTest, ReadsWhatIsWritten) {
  const RigidTransform pose = read("0.36 0.48 -0.8 1e-3\n-0.8 0.6 0 2\n0.48 0.64 0.6 -3e7\n");
  write_pose(pose, 2.5, folder_ / "written.txt");
  const ScaledPose again = read_scaled_pose(folder_ / "written.txt");
  EXPECT_TRUE(again.T_target_source.isApprox(pose, 1e-14));
  EXPECT_NEAR(again.scale, 2.5, 1e-14);
}

TEST_F(PoseReadingTest, MakesARotationOfRoundedNumbers) {
  const RigidTransform pose = read("0.866 -0.5 0 0\n0.5 0.866 0 0\n0 0 1 0\n");
  EXPECT_TRUE((pose.linear() * pose.linear().transpose()).isIdentity(1e-15));
  EXPECT_GT(pose.linear().determinant(), 0.0);
  EXPECT_NEAR(pose.linear()(0, 0), 0.866, 1e-4);
}

TEST_F(PoseReadingTest, RefusesWhatIsNoRigidPose) {
  for (const char* text : {
           "",
           "1 0 0 0\n0 1 0 0\n",                             // two rows
           "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n0 0 0 1\n",  // five
           "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 2\n",           // projective
           "2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n",           // scaled
           "1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n",          // reflection
           "0 0 0 0\n0 0 0 0\n0 0 0 0\n0 0 0 1\n",           // nothing
           "1 0 0 nan\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
           "1 0 0\n0 1 0\n0 0 1\n",  // rotation alone
           "1.01 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
       }) {
    EXPECT_THROW((void)read(text), std::runtime_error) << text;
  }
}

TEST_F(PoseReadingTest, ReadsAScale) {
  test::write_text(folder_ / "pose.txt", "0 -0.5 0 5\n0.5 0 0 6\n0 0 0.5 7\n");
  const ScaledPose pose = read_scaled_pose(folder_ / "pose.txt");
  EXPECT_DOUBLE_EQ(pose.scale, 0.5);
  EXPECT_TRUE((pose.T_target_source * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(5, 7, 7)));
  for (const char* text :
       {"0 0 0 0\n0 0 0 0\n0 0 0 0\n", "1 0 0 0\n0 2 0 0\n0 0 1 0\n", "-1 0 0 0\n0 1 0 0\n0 0 1 0\n"}) {
    test::write_text(folder_ / "pose.txt", text);
    EXPECT_THROW(static_cast<void>(read_scaled_pose(folder_ / "pose.txt")), std::runtime_error) << text;
  }
}

class ProblemReadingTest : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
};

TEST_F(ProblemReadingTest, ReadsWhatIsWritten) {
  const Problem written = noise_study_problem({.correspondences = 100, .outlier_ratio = 0.3, .sigma = 0.1});
  write_problem(written, folder_ / "p");
  const Problem read = read_problem(folder_ / "p/correspondences.txt", folder_ / "p/pose.txt", 1.0);
  EXPECT_EQ(read.source, written.source);
  EXPECT_EQ(read.target, written.target);
  EXPECT_EQ(read.is_inlier, written.is_inlier);
  EXPECT_TRUE(read.T_target_source.isApprox(written.T_target_source, 1e-14));
  EXPECT_EQ(read_correspondences(folder_ / "p/correspondences.txt").size(), 100u);
}

class ColumnsTest : public testing::Test {
 protected:
  /// Ten rows, a point apart by 1, 2, ... 6 in each coordinate, made by row(k).
  template <typename Row>
  std::string rows(const std::string& first, const Row& row) {
    std::string text = first;
    for (int k = 0; k < 10; ++k) text += row(k) + "\n";
    return text;
  }
  /// Source and target of the second row less those of the first.
  std::vector<double> read(const std::string& text, std::span<const std::size_t> columns = {}) {
    test::write_text(folder_ / "rows.csv", text);
    const Correspondences read = read_correspondences(folder_ / "rows.csv", columns);
    EXPECT_EQ(read.size(), 10u);
    std::vector<double> steps;
    for (const bool source : {true, false}) {
      for (std::size_t c = 0; c < 3; ++c) {
        const float* values = source ? read.view().source(c) : read.view().target(c);
        steps.push_back(std::round(1e3 * static_cast<double>(values[1] - values[0]) / read.scale()) / 1e3);
      }
    }
    return steps;
  }
  test::TemporaryFolder folder_;
};

std::string point(int k, const char* separator = ",") {
  std::string text;
  for (int c = 1; c <= 6; ++c) text += (c > 1 ? separator : "") + std::to_string(c * k);
  return text;
}

TEST_F(ColumnsTest, AreUnderstoodWhereTheyTell) {
  const std::vector<double> expected{1, 2, 3, 4, 5, 6};
  const auto indexed = [](int k) { return std::to_string(k + 1) + "," + point(k); };
  const auto scored = [](int k) { return "0.7," + point(k) + ",1"; };
  EXPECT_EQ(read(rows("", [](int k) { return point(k, ";"); })), expected);
  EXPECT_EQ(read(rows("", [](int k) { return std::to_string(k) + " " + point(k, " "); })), expected);
  EXPECT_EQ(read(rows("", indexed)), expected);
  EXPECT_EQ(read(rows("sx,sy,sz,tx,ty,tz\n", [](int k) { return point(k); })), expected);
  EXPECT_EQ(read(rows("a,b,c,d,e,f\n", [](int k) { return point(k); })), expected);
  EXPECT_EQ(read(rows("score,\"X1\",Y1,Z1,x2,y2,z2,label\n", scored)), expected);
  EXPECT_EQ(read(rows("score,x_src,y_src,z_src,x_dst,y_dst,z_dst,label\n", scored)), expected);
  const std::vector<double> swapped{4, 5, 6, 1, 2, 3};
  EXPECT_EQ(read(rows("id,target_x,target_y,target_z,source_x,source_y,source_z\n", indexed)), swapped);
  EXPECT_EQ(read(rows("", scored), std::vector<std::size_t>{5, 6, 7, 2, 3, 4}), swapped);
}

TEST_F(ColumnsTest, AreWhatTheirNamesSayInAnyOrder) {
  const auto six = [](int k) { return point(k); };
  const std::vector<double> in_order{1, 2, 3, 4, 5, 6}, swapped{4, 5, 6, 1, 2, 3}, in_turn{1, 3, 5, 2, 4, 6};
  for (const char* const names :
       {"Target X,Target Y,Target Z,Source X,Source Y,Source Z", "tx in m,ty in m,tz in m,sx in m,sy in m,sz in m",
        "targetX,targetY,targetZ,sourceX,sourceY,sourceZ", "Xtarget,Ytarget,Ztarget,Xsource,Ysource,Zsource",
        "target:x,target:y,target:z,source:x,source:y,source:z", "x2,y2,z2,x1,y1,z1", "tx,ty,tz,sx,sy,sz",
        "X_ref,Y_ref,Z_ref,X,Y,Z", "qx,qy,qz,px,py,pz", "x10,y10,z10,x9,y9,z9", "p1_x,p1_y,p1_z,p0_x,p0_y,p0_z"}) {
    EXPECT_EQ(read(rows(names + std::string("\n"), six)), swapped) << names;
  }
  for (const char* const names :
       {"x1 [m],y1 [m],z1 [m],x2 [m],y2 [m],z2 [m]", "x,y,z,x,y,z", "x_from,y_from,z_from,x_to,y_to,z_to",
        "ax,ay,az,bx,by,bz", "cam.x,cam.y,cam.z,map.x,map.y,map.z", "x,y,z,x',y',z'"}) {
    EXPECT_EQ(read(rows(names + std::string("\n"), six)), in_order) << names;
  }
  EXPECT_EQ(read(rows("x1,x2,y1,y2,z1,z2\n", six)), in_turn);
  EXPECT_EQ(read(rows("x2,x1,y2,y1,z2,z1\n", six)), (std::vector<double>{2, 4, 6, 1, 3, 5}));
  // As NumPy's savetxt writes a header; what does not tell all is prose.
  EXPECT_EQ(read(rows("# x2 y2 z2 x1 y1 z1\n", six)), swapped);
  EXPECT_EQ(read(rows("# x2 y2 z2 x1 y1 z1\n# made by me\nV1,V2,V3,V4,V5,V6\n", six)), swapped);
  EXPECT_EQ(read(rows("// tx,ty,tz,sx,sy,sz\n", six)), swapped);
  EXPECT_EQ(read(rows("# x2 y2 z2 x1 y1 z1\nx1,y1,z1,x2,y2,z2\n", six)), in_order);
  EXPECT_EQ(read(rows("# how far x is from y\n", six)), in_order);
  for (const char* const names : {"x,y,z,nx,ny,nz", "x,y,z,r,g,b", "x,x,y,y,z,z", "x1,y1,x2,y2,x3,y3"}) {
    EXPECT_THAT([&] { (void)read(rows(names + std::string("\n"), six)); },
                testing::ThrowsMessage<std::exception>(testing::HasSubstr("which do not tell source x y z")))
        << names;
  }
}

// Rows may begin with a number of their own, which the names do not count; columns may be named by numbers.
TEST_F(ColumnsTest, AreCountedAsRAndPandasDo) {
  const std::vector<double> swapped{4, 5, 6, 1, 2, 3};
  const auto indexed = [](int k) { return std::to_string(k + 1) + " " + point(k, " "); };
  EXPECT_EQ(read(rows("\"tx\" \"ty\" \"tz\" \"sx\" \"sy\" \"sz\"\n", indexed)), swapped);
  EXPECT_EQ(read(rows("\ttx\tty\ttz\tsx\tsy\tsz\n", [](int k) { return std::to_string(k) + "\t" + point(k, "\t"); })),
            swapped);
  EXPECT_EQ(read(rows("tx,ty,tz,sx,sy,sz\n", [](int k) { return point(2 * k) + ",0.5"; })),
            (std::vector<double>{8, 10, 12, 2, 4, 6}));
  EXPECT_EQ(read(rows("0,1,2,3,4,5\n", [](int k) { return point(k) + ".5"; })),
            (std::vector<double>{1, 2, 3, 4, 5, 6}));
}

TEST_F(ColumnsTest, AreAskedForWhereTheyDoNot) {
  const auto scored = [](int k) { return "0.5," + point(k); };
  const auto refused = [&](const std::string& text, const std::string& says, std::vector<std::size_t> columns = {}) {
    EXPECT_THAT([&] { (void)read(text, columns); }, testing::ThrowsMessage<std::exception>(testing::HasSubstr(says)));
  };
  refused(rows("", scored), "rows.csv: 7 numbers a line, expected 6: say which");
  refused(rows("x,y,z,nx,ny,nz,w\n", scored), "--columns");
  refused(rows("target[0],target[1],target[2],source[0],source[1],source[2]\n", [](int k) { return point(k); }),
          "which do not tell source x y z");
  refused(rows("tx,ty,tz,sx\n", [](int k) { return point(k); }), "4 names, but 6 numbers a line");
  refused(rows("", scored), "column 8 of 7", {1, 2, 3, 4, 5, 8});
  refused(rows("", scored), "six of them", {1, 2, 3});
  refused(rows("", scored), "six of them", {0, 1, 2, 3, 4, 5});
  refused(rows("", scored) + "1,2,3,4,5,6\n", "rows.csv:11: expected 7 numbers, got 6");
  refused(rows("", [](int k) { return point(k) + "," + point(k); }),
          "write points where commas are decimal ones, else");
  refused(rows("", [](int k) { return std::to_string(k); }),
          "rows.csv:1: expected 6 numbers, got 1: a correspondence is a line of source x y z and target x y z");
  refused(rows("", [](int k) { return std::to_string(k) + " 2 3"; }), "are given as SOURCE TARGET --pairs rows");
  const auto halves = [](int k) { return std::to_string(k) + ",5 1 2 3,5 1 2"; };
  const std::string decimal = "1: '0,5' has a decimal comma: write decimal points, as 'tr , . < FILE' does";
  refused(rows("", halves), "rows.csv:" + decimal);
  refused(halves(0) + "\n" + rows("", [](int k) { return point(k, " "); }), "rows.csv:" + decimal);
  refused(rows("", [](int k) { return point(k, " "); }) + halves(0) + "\n", "rows.csv:1" + decimal);
  refused(rows("", halves) + "1 2 3 4 5 6\n", "rows.csv:" + decimal, {2, 3, 4, 5, 6, 1});
}

TEST_F(ProblemReadingTest, NamesTheFileAtFault) {
  write_problem(noise_study_problem({.correspondences = 100}), folder_ / "p");
  const std::filesystem::path rows = folder_ / "p/correspondences.txt", pose = folder_ / "p/pose.txt";
  const auto refused = [&](const std::string& says) {
    EXPECT_THAT([&] { (void)read_problem(rows, pose, 1.0); },
                testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr(says)));
  };
  test::write_text(pose, "1 0 0 0\n0 1 0 0\n");
  refused("pose.txt: expected 3 or 4 rows, got 2");
  test::write_text(rows, "0 0 0 0 0 0\n1 1 1 1 1\n");
  refused("correspondences.txt:2: expected 6 numbers, got 5");
  test::write_text(rows, "0 0 0 0 0 0\n1 1 1 1 1 1\n");
  refused("correspondences.txt: expected at least 3 correspondences, got 2: a pose needs three");
  std::filesystem::remove(rows);
  refused("correspondences.txt: cannot read: No such file or directory");
}

}  // namespace
}  // namespace consimd::synth
