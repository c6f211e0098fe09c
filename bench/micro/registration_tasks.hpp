// What the registration benchmarks register.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/synth/noise_study.hpp>

#include "eigen_baseline.hpp"

namespace consimd::bench {

struct RegistrationTask {
  Correspondences correspondences;
  EigenCloud eigen;  ///< the same, for the baseline
  double noise_bound = 0.0;
  std::function<bool(const RigidTransform&)> found;    ///< whether a pose is the right one
  std::function<double(const RigidTransform&)> error;  ///< how far off it is
};

/// Right is a root mean square error of the true inliers, the task's error, below 3 sigma.
[[nodiscard]] RegistrationTask noise_study_task(const synth::NoiseStudyOptions& options);

/// Folders of the recorded pairs, CASE/{correspondences.txt,pose.txt,case.json}, below `correspondences` in the folder
/// that the environment variable CONSIMD_TEST_DATA names. None if it names none.
[[nodiscard]] std::vector<std::filesystem::path> recorded_pairs();

/// Right is within the error limits of the case; the error is that of the translation. Throws std::runtime_error where
/// a file does not hold what it should.
[[nodiscard]] RegistrationTask recorded_task(const std::filesystem::path& folder);

}  // namespace consimd::bench
