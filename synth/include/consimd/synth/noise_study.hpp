// The generator of the paper's noise study (section "Noise Study").
#pragma once

#include <cstddef>
#include <cstdint>

#include <consimd/kernels/export.hpp>
#include <consimd/synth/problem.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

/// One trial's data depend on these values alone: every solver sees the same bytes.
struct NoiseStudyOptions {
  std::size_t correspondences = 3000;  ///< N >= 1
  double outlier_ratio = 0.9;          ///< share of correspondences replaced by random ones, in [0, 1];
                                       ///< floor(N * (1 - ratio) + 1/2) inliers remain
  double sigma = 1.0;                  ///< metres, >= 0
  double half_extent = 100.0;          ///< points lie in [-half_extent, half_extent]^3, metres, > 0
  std::uint64_t seed = 1;
  std::uint64_t trial = 0;
  double scale = 1.0;  ///< > 0; source points are divided by it. Not part of the study
};

/// Source points uniform in the cube, a uniformly random rotation and a translation uniform in the cube; targets are
/// the moved sources; a random subset of the rows gets targets uniform in the cube instead; Gaussian noise on the
/// inliers' targets. Throws std::invalid_argument on an option outside its range.
[[nodiscard]] Problem noise_study_problem(const NoiseStudyOptions& options);

/// The bound that the study gives a solver: 3 sigma.
[[nodiscard]] constexpr double noise_study_bound(double sigma) noexcept { return 3.0 * sigma; }

}  // namespace synth
}  // namespace consimd
