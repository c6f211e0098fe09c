// Families of problems that a study runs over the same outlier ratios and noise levels: the paper's, and others that
// differ from it in one thing each.
#pragma once

#include <span>
#include <string_view>

#include <consimd/kernels/export.hpp>
#include <consimd/synth/noise_study.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

struct ProblemFamily {
  std::string_view name;      ///< "gaussian", "heavy_tails", ...
  std::string_view sentence;  ///< how its problems differ from the paper's
  /// Whether an inlier's residual is Gaussian with the deviation sigma on every axis, as the paper's success measure
  /// (RMSE below 3 sigma) takes it to be.
  bool gaussian_noise;
};

/// All of them, the paper's first.
[[nodiscard]] std::span<const ProblemFamily> problem_families() noexcept;

/// That of the name. Throws std::invalid_argument on an unknown one, listing the known ones.
[[nodiscard]] const ProblemFamily& problem_family(std::string_view name);

/// A problem of the family with so many correspondences, floor(N (1 - outlier_ratio) + 1/2) of them true (of `copies`
/// on average), and noise whose standard deviation per axis is sigma over all inliers (more by rounding of
/// `quantised`). outlier_ratio = 1 gives one without a true pose. Problems of two families share the random numbers of
/// all that they have in common. Throws std::invalid_argument as `problem_family` and `noise_study_problem` do.
[[nodiscard]] Problem family_problem(std::string_view family, const NoiseStudyOptions& options);

}  // namespace synth
}  // namespace consimd
