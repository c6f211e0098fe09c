// Digests of what every generator makes, every solver finds and a small study records, as far as this build has these.
// They are the same on every processor, for every compiler, C library, instruction set and number of threads:
// golden_digests.txt has them.
//
// consimd_golden_digests [FILE]: prints a line "NAME DIGEST" each. With FILE it is silent where the lines of FILE are
// the same, and otherwise prints which differ and exits with 1.
#include <array>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <consimd/synth/field_problems.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>
#include <consimd/synth/stand_ins.hpp>

#include "digest.hpp"

namespace consimd::golden {
namespace {

Digest digest_of(const synth::Problem& problem) {
  Digest digest;
  digest.add_all(problem.source);
  digest.add_all(problem.target);
  for (const std::uint8_t label : problem.is_inlier) digest.add(std::uint64_t{label});
  digest.add(problem.T_target_source);
  digest.add(problem.decoy_T_target_source);
  digest.add(problem.scale);
  digest.add(problem.sigma);
  return digest;
}

void add_problems(Digests& digests) {
  const auto add = [&](const std::string& name, const synth::Problem& problem) {
    digests.emplace_back("problem:" + name, digest_of(problem).value());
  };
  const synth::Problem study = synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.5});
  add("noise_study", study);
  add("noise_study,scale", synth::noise_study_problem({.correspondences = 100, .trial = 7, .scale = 1.7}));

  // So many that a function which rounds differently once in ten thousand calls shows.
  add("noise_study,large", synth::noise_study_problem({.correspondences = 300000, .outlier_ratio = 0.1}));

  using synth::NoiseModel;
  using synth::OutlierModel;
  using synth::Scene;
  const std::array scenes{Scene::volume, Scene::planar,   Scene::linear, Scene::rings,  Scene::poles,
                          Scene::lines,  Scene::corridor, Scene::room,   Scene::facade, Scene::grid};
  const std::array outliers{OutlierModel::uniform,     OutlierModel::permuted,     OutlierModel::clustered,
                            OutlierModel::one_to_many, OutlierModel::many_to_many, OutlierModel::alike};
  const std::array noises{NoiseModel::gaussian, NoiseModel::range_dependent, NoiseModel::student_t};
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    for (std::size_t o = 0; o < outliers.size(); ++o) {
      const synth::HardProblemOptions options{.correspondences = 300,
                                              .outlier_ratio = 0.7,
                                              .scene = scenes[s],
                                              .outliers = outliers[o],
                                              .decoy_share = 0.3,
                                              .symmetric = o == 1,
                                              .noise = noises[(s + o) % noises.size()],
                                              .duplicates = o == 2 ? std::size_t{5} : std::size_t{0},
                                              .units_per_metre = o == 3 ? 1000.0 : 1.0};
      add("hard,scene=" + std::to_string(s) + ",outliers=" + std::to_string(o), synth::hard_problem(options));
    }
  }
  add("far_rows", synth::with_far_rows(study, {.rows = 20}));
  add("rows_without_depth", synth::with_rows_without_depth(study, 20));
  add("repeated_targets", synth::repeated_targets({.blunders = 0.2, .copied = false}));
  add("all_to_all", synth::all_to_all({}));
  add("symmetric_part", synth::symmetric_part({}));
  for (const synth::StandIn& stand_in : synth::stand_ins()) {
    add("stand_in," + std::string(stand_in.name), synth::stand_in_problem(stand_in, 1, 0));
  }
}

/// Of problems with inliers and of one without.
void add_errors(Digests& digests) {
  Digest digest;
  for (const double outliers : {0.0, 0.5, 0.9, 1.0}) {
    const synth::Problem problem = synth::hard_problem({.correspondences = 700, .outlier_ratio = outliers});
    const RigidTransform oracle = synth::oracle(problem);
    digest.add(oracle);
    digest.add(synth::rotation_error_deg(oracle, problem.T_target_source));
    digest.add(synth::translation_error(oracle, problem.T_target_source));
    digest.add(synth::rmse_true_inliers(problem, oracle));
  }
  digests.emplace_back("errors:oracle", digest.value());
}

// "problem", "registration", ...
std::string kind_of(const std::string& name) { return name.substr(0, name.find(':')); }

/// Returns whether there are none, among the kinds of digests that this build has.
bool print_differences(const Digests& digests, const std::string& file) {
  std::ifstream in(file);
  std::map<std::string, std::string> expected;
  for (std::string line; std::getline(in, line);) {
    const std::size_t space = line.rfind(' ');
    if (space != std::string::npos) expected[line.substr(0, space)] = line.substr(space + 1);
  }
  std::size_t differences = 0;
  std::set<std::string> kinds;
  for (const auto& [name, value] : digests) {
    kinds.insert(kind_of(name));
    std::ostringstream digest;
    digest << std::hex << value;
    const std::string wanted = expected[name];
    expected.erase(name);
    if (wanted == digest.str()) continue;
    ++differences;
    std::cerr << name << ": " << digest.str() << ", expected " << (wanted.empty() ? "none" : wanted) << '\n';
  }
  for (const auto& [name, value] : expected) {
    if (!kinds.contains(kind_of(name))) continue;
    ++differences;
    std::cerr << name << ": none, expected " << value << '\n';
  }
  if (differences != 0) {
    std::cerr << differences << " differences from " << file
              << ". Where a change of results is meant, write them there anew: the output without an argument.\n";
  }
  return differences == 0;
}

int run(int argc, char** argv) {
  Digests digests;
  add_problems(digests);
  add_errors(digests);
#ifdef CONSIMD_GOLDEN_REGISTRATIONS
  add_registrations(digests);
  add_clouds(digests);
#endif
#ifdef CONSIMD_GOLDEN_STUDY
  add_study(digests);
#endif
  if (argc > 1) return print_differences(digests, argv[1]) ? 0 : 1;
  for (const auto& [name, value] : digests) std::cout << name << ' ' << std::hex << value << std::dec << '\n';
  return 0;
}

}  // namespace
}  // namespace consimd::golden

int main(int argc, char** argv) {
  try {
    return consimd::golden::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "golden_digests: " << error.what() << '\n';
    return 2;
  }
}
