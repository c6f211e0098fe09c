#include "registration_tasks.hpp"

#include <algorithm>
#include <cstdlib>

#include <consimd/studies/case_folder.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/problem_files.hpp>

#include "workload.hpp"

namespace consimd::bench {
RegistrationTask noise_study_task(const synth::NoiseStudyOptions& options) {
  const synth::Problem problem = synth::noise_study_problem(options);
  return {
      problem.correspondences(), eigen_cloud(problem.source, problem.target), synth::noise_study_bound(options.sigma),
      [problem](const RigidTransform& pose) { return synth::rmse_true_inliers(problem, pose) < 3.0 * problem.sigma; },
      [problem](const RigidTransform& pose) { return synth::rmse_true_inliers(problem, pose); }};
}

std::vector<std::filesystem::path> recorded_pairs() {
  std::vector<std::filesystem::path> folders;
  const char* const data = std::getenv("CONSIMD_TEST_DATA");
  if (data == nullptr) return folders;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / "correspondences")) {
    if (std::filesystem::exists(entry.path() / "case.json")) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

RegistrationTask recorded_task(const std::filesystem::path& folder) {
  const std::filesystem::path case_path = folder / "case.json";
  const studies::CaseFile file = studies::read_case_file(case_path);
  const studies::PoseLimits limits = file.limits(case_path);
  const synth::Problem problem =
      synth::read_problem(folder / "correspondences.txt", folder / "pose.txt", file.noise_bound);
  return {problem.correspondences(), eigen_cloud(problem.source, problem.target), file.noise_bound,
          [limits, truth = problem.T_target_source](const RigidTransform& estimate) {
            return synth::rotation_error_deg(estimate, truth) <= limits.rotation_deg &&
                   synth::translation_error(estimate, truth) <= limits.translation;
          },
          [truth = problem.T_target_source](const RigidTransform& estimate) {
            return synth::translation_error(estimate, truth);
          }};
}

}  // namespace consimd::bench
