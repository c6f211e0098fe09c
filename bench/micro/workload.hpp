// The data that the kernel benchmarks of one size share.
#pragma once

#include <cstddef>
#include <vector>

#include <consimd/studies/kernel_workload.hpp>

#include "eigen_baseline.hpp"
#include "loop_baseline.hpp"

namespace consimd::bench {

/// N x 3 coordinates each, row-major.
[[nodiscard]] EigenCloud eigen_cloud(const std::vector<double>& source, const std::vector<double>& target);

/// The library's workload, and the same in the forms that the baselines read.
struct Workload : studies::KernelWorkload {
  Workload(std::size_t size, std::size_t batch);

  EigenCloud eigen;                    ///< double, caller's frame
  std::vector<EigenPose> eigen_poses;  ///< `transforms`
  LoopCloud loop;                      ///< the arrays of `correspondences`
  std::vector<LoopPose> loop_poses;    ///< `poses`
  float loop_noise_bound = 0.0f;       ///< working frame, as `loop`
  float loop_consistency_bound = 0.0f;
};

/// The workload of a size and a number of hypotheses at once, made at its first use.
[[nodiscard]] const Workload& workload(std::size_t size, std::size_t batch);

}  // namespace consimd::bench
