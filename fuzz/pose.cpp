// Files of poses.
#include <consimd/synth/problem_files.hpp>

#include <cmath>

#include "byte_file.hpp"

namespace {

void require_rigid(const consimd::RigidTransform& pose) {
  using consimd::fuzz::require;
  require(pose.matrix().allFinite(), "finite poses");
  const Eigen::Matrix3d rotation = pose.linear();
  require((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-9, "rotations");
  require(rotation.determinant() > 0.0, "no reflections");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace consimd;
  const fuzz::ByteFile file(data, size);
  fuzz::may_refuse([&] { require_rigid(synth::read_pose(file.path())); });
  fuzz::may_refuse([&] {
    const synth::ScaledPose pose = synth::read_scaled_pose(file.path());
    require_rigid(pose.T_target_source);
    fuzz::require(std::isfinite(pose.scale) && pose.scale > 0.0, "a scale above 0");
  });
  return 0;
}
