#include <consimd/synth/noise_study.hpp>

#include <consimd/synth/hard_problems.hpp>

namespace consimd::synth {

Problem noise_study_problem(const NoiseStudyOptions& options) {
  // Volume scene, uniform outliers and Gaussian noise are the defaults of the general generator.
  return hard_problem({.correspondences = options.correspondences,
                       .outlier_ratio = options.outlier_ratio,
                       .sigma = options.sigma,
                       .half_extent = options.half_extent,
                       .seed = options.seed,
                       .trial = options.trial,
                       .scale = options.scale});
}

}  // namespace consimd::synth
