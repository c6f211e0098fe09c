// The data that kernels are timed on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/synth/problem.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// A problem of the noise study, 90 % outliers, sigma 1 m, with hypotheses drawn from it; the same for the same size
/// and batch, everywhere.
struct KernelWorkload {
  /// Hypotheses that a kernel is given at once unless told otherwise, a round of the solvers.
  static constexpr std::size_t kBatch = 64;

  /// size: correspondences, 3 or more. batch: hypotheses, 1 or more. Throws std::invalid_argument otherwise.
  explicit KernelWorkload(std::size_t size, std::size_t batch = kBatch);

  [[nodiscard]] std::size_t size() const noexcept { return correspondences.size(); }
  [[nodiscard]] std::size_t batch() const noexcept { return seeds.size(); }
  /// In [0, 1), one for each padded row, 64-byte aligned.
  [[nodiscard]] const float* weights() const noexcept { return weights_.get(); }

  double noise_bound = 3.0;        ///< of a residual, metres
  double consistency_bound = 6.0;  ///< of a difference of lengths

  synth::Problem problem;
  Correspondences correspondences;         ///< of `problem`
  std::vector<std::uint32_t> seeds;        ///< batch()
  std::vector<IndexPair> pairs;            ///< batch()
  std::vector<IndexTriple> triples;        ///< size(): a fit is short beside the other kernels' hypotheses
  std::vector<RigidTransform> transforms;  ///< batch(); the true pose, disturbed by up to some degrees and metres
  std::vector<WorkingPose> poses;          ///< `transforms` in the working frame
  std::vector<std::uint64_t> chosen;       ///< bits of a third of the correspondences
  std::vector<std::uint32_t> rows;         ///< the same as indices

 private:
  struct AlignedDelete {
    void operator()(float* weights) const noexcept;
  };
  std::unique_ptr<float[], AlignedDelete> weights_;
};

}  // namespace studies
}  // namespace consimd
