// Registers one synthetic problem and holds the pose against the ground truth.
#include <iostream>

#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

int main() {
  const consimd::synth::NoiseStudyOptions study{.correspondences = 1000, .outlier_ratio = 0.9, .sigma = 0.1};
  const consimd::synth::Problem problem = consimd::synth::noise_study_problem(study);

  const double noise_bound = consimd::synth::noise_study_bound(study.sigma);
  const consimd::Registration registration =
      consimd::register_by_name("tcf", problem.correspondences(), {.noise_bound = noise_bound});

  const double rotation_error =
      consimd::synth::rotation_error_deg(registration.T_target_source, problem.T_target_source);
  std::cout << consimd::to_string(registration.status) << ", " << registration.inliers.size()
            << " inliers, rotation error " << rotation_error << " degrees\n";
  return registration.has_pose() && rotation_error < 1.0 ? 0 : 1;
}
