// Of registrations, by every solver, and of a pair of clouds.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <consimd/features/register_clouds.hpp>
#include <consimd/kernels/cloud.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/stand_ins.hpp>

#include "digest.hpp"

namespace consimd::golden {
namespace {

/// All but times, the instruction set and the number of threads.
Digest digest_of(const Registration& r) {
  Digest digest;
  digest.add(to_string(r.status));
  digest.add(r.T_target_source);
  digest.add_matrix(r.covariance);
  for (const double value :
       {r.scale, r.scale_deviation, r.log10_false_poses, r.noise_bound, r.noise_bound_asked, r.consistency_bound}) {
    digest.add(value);
  }
  for (const std::uint32_t row : r.inliers) digest.add(std::uint64_t{row});
  digest.add(std::uint64_t{r.mirrored});
  if (r.runner_up) {
    digest.add(r.runner_up->T_target_source);
    digest.add(std::uint64_t{r.runner_up->support});
    digest.add(r.runner_up->log10_false_poses);
    digest.add(r.runner_up->scale);
  }
  for (const StageReport& stage : r.stages) {
    digest.add(stage.name);
    digest.add(std::uint64_t{stage.input});
    digest.add(std::uint64_t{stage.output});
    digest.add(stage.iterations);
  }
  return digest;
}

struct RegistrationCase {
  std::string name;
  synth::Problem problem;
  SolverOptions options;
};

std::vector<RegistrationCase> registration_cases() {
  using synth::hard_problem;
  return {
      {"half", hard_problem({.correspondences = 400, .outlier_ratio = 0.5, .sigma = 0.5}), {.noise_bound = 1.5}},
      {"tenth", hard_problem({.correspondences = 400, .outlier_ratio = 0.9, .sigma = 0.5}), {.noise_bound = 1.5}},
      {"ambiguous",
       hard_problem({.correspondences = 300, .outlier_ratio = 0.7, .sigma = 0.5, .decoy_share = 1.0}),
       {.noise_bound = 1.5}},
      {"none", hard_problem({.correspondences = 200, .outlier_ratio = 1.0, .sigma = 1.0}), {.noise_bound = 3.0}},
      {"alike",
       hard_problem({.correspondences = 500,
                     .outlier_ratio = 0.9,
                     .sigma = 0.3,
                     .scene = synth::Scene::corridor,
                     .outliers = synth::OutlierModel::alike}),
       {.noise_bound = 1.0}},
      {"filtered",
       hard_problem({.correspondences = 500, .outlier_ratio = 0.8, .sigma = 0.5}),
       {.noise_bound = 1.5, .filter = Filter::tcf}},
  };
}

}  // namespace

void add_registrations(Digests& digests) {
  const auto add = [&](const std::string& name, const Registration& registration) {
    digests.emplace_back("registration:" + name, digest_of(registration).value());
  };
  for (const RegistrationCase& of : registration_cases()) {
    const Correspondences correspondences = of.problem.correspondences();
    for (const std::string& solver : solver_names()) {
      // It draws all of its samples, which the others of its family do as well.
      if (solver == "ransac-50k" && of.name != "tenth") continue;
      add(solver + "," + of.name, register_by_name(solver, correspondences, of.options));
    }
  }
  const synth::Problem unknown = synth::hard_problem(
      {.correspondences = 300, .outlier_ratio = 0.6, .sigma = 0.5, .noise = synth::NoiseModel::student_t});
  add("tcf,noise bound estimated", register_by_name("tcf", unknown.correspondences(), {}));
  const synth::Problem scaled =
      synth::hard_problem({.correspondences = 300, .outlier_ratio = 0.6, .sigma = 0.5, .scale = 2.5});
  for (const Solver& solver : solvers()) {
    if (!solver.estimates_scale()) continue;
    add(solver.name + ",scale estimated",
        register_by_name(solver.name, scaled.correspondences(), {.noise_bound = 1.5, .estimate_scale = true}));
  }
  const synth::StandIn& arch = synth::stand_in("arch");
  const synth::Problem pair = synth::stand_in_problem(arch, 2, 0);
  add("tcf,stand-in", register_by_name("tcf", pair.correspondences(), {.noise_bound = arch.noise_bound}));
}

void add_clouds(Digests& digests) {
  const synth::Problem room = synth::hard_problem(
      {.correspondences = 5000, .outlier_ratio = 0.0, .sigma = 0.01, .half_extent = 5.0, .scene = synth::Scene::room});
  const Cloud source(PointSpan<double>::interleaved(room.source.data(), room.size()));
  const Cloud target(PointSpan<double>::interleaved(room.target.data(), room.size()));
  const features::CloudRegistration result = features::register_clouds(source, target);
  Digest digest = digest_of(result.registration);
  digest.add(result.matches.voxel);
  digest.add(result.matches.noise_bound);
  for (const auto* points : {&result.matches.source_points, &result.matches.target_points}) {
    for (const std::array<double, 3>& point : *points) digest.add_all(point);
  }
  digests.emplace_back("clouds:room", digest.value());
}

}  // namespace consimd::golden
