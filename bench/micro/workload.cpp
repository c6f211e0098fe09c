#include "workload.hpp"

#include <map>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

namespace consimd::bench {
namespace {

LoopPose loop_pose(const WorkingPose& pose) {
  LoopPose copy{};
  for (int k = 0; k < 9; ++k) copy.rotation[k] = pose.rotation[k];
  for (int k = 0; k < 3; ++k) copy.translation[k] = pose.translation[k];
  return copy;
}

}  // namespace

EigenCloud eigen_cloud(const std::vector<double>& source, const std::vector<double>& target) {
  EigenCloud cloud;
  for (std::size_t k = 0; k < source.size(); k += 3) {
    cloud.source.emplace_back(&source[k]);
    cloud.target.emplace_back(&target[k]);
  }
  return cloud;
}

Workload::Workload(std::size_t size, std::size_t batch)
    : KernelWorkload(size, batch), eigen(eigen_cloud(problem.source, problem.target)) {
  const CorrespondenceView view = correspondences;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    loop.source[axis] = view.source(axis);
    loop.target[axis] = view.target(axis);
  }
  loop.size = size;
  loop_noise_bound = static_cast<float>(noise_bound * view.scale());
  loop_consistency_bound = static_cast<float>(consistency_bound * view.scale());
  for (const RigidTransform& transform : transforms) {
    eigen_poses.push_back({transform.linear(), transform.translation()});
  }
  for (const WorkingPose& pose : poses) loop_poses.push_back(loop_pose(pose));
}

const Workload& workload(std::size_t size, std::size_t batch) {
  static std::map<std::pair<std::size_t, std::size_t>, Workload> workloads;
  const auto made = workloads.find({size, batch});
  if (made != workloads.end()) return made->second;
  return workloads
      .emplace(std::piecewise_construct, std::forward_as_tuple(size, batch), std::forward_as_tuple(size, batch))
      .first->second;
}

}  // namespace consimd::bench
