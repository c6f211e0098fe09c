// The data that the kernel benchmarks of one size share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "eigen_baseline.hpp"
#include "loop_baseline.hpp"

namespace consimd::bench {

/// Hypotheses that a kernel is given at once, a round of the solvers.
inline constexpr std::size_t kBatch = 64;

/// N x 3 coordinates each, row-major.
[[nodiscard]] EigenCloud eigen_cloud(const std::vector<double>& source, const std::vector<double>& target);

/// A problem of the noise study, 90 % outliers, sigma 1 m, with hypotheses drawn from it; and the same in the forms
/// that the baselines read.
struct Workload {
  explicit Workload(std::size_t size);

  [[nodiscard]] std::size_t size() const noexcept { return correspondences.size(); }
  [[nodiscard]] const float* weights() const noexcept { return weights_.get(); }

  double noise_bound = 3.0;        ///< of a residual, metres
  double consistency_bound = 6.0;  ///< of a difference of lengths

  Correspondences correspondences;
  std::vector<std::uint32_t> seeds;   ///< kBatch
  std::vector<IndexPair> pairs;       ///< kBatch
  std::vector<IndexTriple> triples;   ///< size(): a fit is short beside the other kernels' hypotheses
  std::vector<WorkingPose> poses;     ///< kBatch; the true pose, disturbed by up to some degrees and metres
  std::vector<std::uint64_t> chosen;  ///< bits of a third of the correspondences
  std::vector<std::uint32_t> rows;    ///< the same as indices

  EigenCloud eigen;                    ///< double, caller's frame
  std::vector<EigenPose> eigen_poses;  ///< `poses` in the caller's frame
  LoopCloud loop;                      ///< the arrays of `correspondences`
  std::vector<LoopPose> loop_poses;    ///< `poses`
  float loop_noise_bound = 0.0f;       ///< working frame, as `loop`
  float loop_consistency_bound = 0.0f;

 private:
  struct AlignedDelete {
    void operator()(float* weights) const noexcept;
  };
  std::unique_ptr<float[], AlignedDelete> weights_;
};

/// The workload of a size, made at its first use.
[[nodiscard]] const Workload& workload(std::size_t size);

}  // namespace consimd::bench
