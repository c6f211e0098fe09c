#include "workload.hpp"

#include <map>
#include <new>
#include <random>

#include <Eigen/Geometry>

#include <consimd/poses/rigid_fit.hpp>
#include <consimd/synth/noise_study.hpp>

namespace consimd::bench {
namespace {

constexpr std::align_val_t kAlignment{64};

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

void Workload::AlignedDelete::operator()(float* weights) const noexcept { ::operator delete[](weights, kAlignment); }

Workload::Workload(std::size_t size) {
  const synth::Problem problem =
      synth::noise_study_problem({.correspondences = size, .outlier_ratio = 0.9, .sigma = noise_bound / 3.0});
  correspondences = problem.correspondences();
  const CorrespondenceView view = correspondences;
  eigen = eigen_cloud(problem.source, problem.target);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    loop.source[axis] = view.source(axis);
    loop.target[axis] = view.target(axis);
  }
  loop.size = size;
  loop_noise_bound = static_cast<float>(noise_bound * view.scale());
  loop_consistency_bound = static_cast<float>(consistency_bound * view.scale());

  std::mt19937_64 bits(1);
  const auto unit = [&bits] { return static_cast<double>(bits() >> 11) * 0x1p-52 - 1.0; };  // [-1, 1)
  const auto row = [&bits, size] { return static_cast<std::uint32_t>(bits() % size); };
  const auto vector = [&unit] {
    const double x = unit(), y = unit(), z = unit();
    return Eigen::Vector3d(x, y, z);
  };
  for (std::size_t h = 0; h < kBatch; ++h) {
    seeds.push_back(row());
    const std::uint32_t first = row();
    pairs.push_back({first, row()});
    const Eigen::AngleAxisd turn(0.05 * unit(), vector().normalized());
    const RigidTransform pose = Eigen::Translation3d(2.0 * vector()) * problem.T_target_source * turn;
    poses.push_back(to_working_pose(to_working_frame(pose, correspondences)));
    eigen_poses.push_back({pose.linear(), pose.translation()});
    loop_poses.push_back(loop_pose(poses.back()));
  }
  for (std::size_t h = 0; h < size; ++h) {
    const std::uint32_t first = row();
    const std::uint32_t second = row();
    triples.push_back({first, second, row()});
  }

  chosen.resize(view.words());
  weights_.reset(static_cast<float*>(::operator new[](view.padded_size() * sizeof(float), kAlignment)));
  for (std::size_t j = 0; j < view.padded_size(); ++j) {
    weights_[j] = static_cast<float>(0.5 + 0.5 * unit());
    if (j >= size || bits() % 3 != 0) continue;
    chosen[j / 64] |= std::uint64_t{1} << (j % 64);
    rows.push_back(static_cast<std::uint32_t>(j));
  }
}

const Workload& workload(std::size_t size) {
  static std::map<std::size_t, Workload> workloads;
  return workloads.try_emplace(size, size).first->second;
}

}  // namespace consimd::bench
