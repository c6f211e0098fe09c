#include "pose_file.hpp"

#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "temporary_folder.hpp"

namespace consimd::cli {
namespace {

class PoseFileTest : public testing::Test {
 protected:
  RigidTransform read(const std::string& text) {
    studies::write_text(folder_ / "pose.txt", text);
    return read_pose(folder_ / "pose.txt");
  }
  studies::TemporaryFolder folder_;
};

constexpr const char* kQuarterTurn = "0 -1 0 5\n1 0 0 6\n0 0 1 7\n";

TEST_F(PoseFileTest, ReadsThreeAndFourRows) {
  for (const std::string& text : {std::string(kQuarterTurn), kQuarterTurn + std::string("0 0 0 1\n")}) {
    const Eigen::Vector3d moved = read(text) * Eigen::Vector3d(1, 0, 0);
    EXPECT_TRUE(moved.isApprox(Eigen::Vector3d(5, 7, 7))) << moved.transpose();
  }
}

TEST_F(PoseFileTest, MakesARotationOfRoundedNumbers) {
  const RigidTransform pose = read("0.866 -0.5 0 0\n0.5 0.866 0 0\n0 0 1 0\n");
  EXPECT_TRUE((pose.linear() * pose.linear().transpose()).isIdentity(1e-15));
  EXPECT_GT(pose.linear().determinant(), 0.0);
  EXPECT_NEAR(pose.linear()(0, 0), 0.866, 1e-4);
}

TEST_F(PoseFileTest, RefusesWhatIsNoRigidPose) {
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

TEST_F(PoseFileTest, ReadsAScale) {
  studies::write_text(folder_ / "pose.txt", "0 -0.5 0 5\n0.5 0 0 6\n0 0 0.5 7\n");
  const ScaledPose pose = read_scaled_pose(folder_ / "pose.txt");
  EXPECT_DOUBLE_EQ(pose.scale, 0.5);
  EXPECT_TRUE((pose.T_target_source * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(5, 7, 7)));
  for (const char* text :
       {"0 0 0 0\n0 0 0 0\n0 0 0 0\n", "1 0 0 0\n0 2 0 0\n0 0 1 0\n", "-1 0 0 0\n0 1 0 0\n0 0 1 0\n"}) {
    studies::write_text(folder_ / "pose.txt", text);
    EXPECT_THROW(static_cast<void>(read_scaled_pose(folder_ / "pose.txt")), std::runtime_error) << text;
  }
}

}  // namespace
}  // namespace consimd::cli
