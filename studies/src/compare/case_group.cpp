#include <consimd/studies/case_group.hpp>

#include <fmt/format.h>

#include <consimd/synth/noise_study.hpp>
#include <consimd/synth/stand_ins.hpp>

#include <consimd/studies/sweep_options.hpp>

namespace consimd::studies {

std::vector<CaseGroup> stand_in_groups(const std::vector<std::string>& names, std::uint32_t pairs, std::uint64_t seed,
                                       std::string_view preset) {
  std::vector<CaseGroup> groups;
  for (const std::string& name : names) {
    const synth::StandIn& stand_in = synth::stand_in(name);
    PoseLimits limits = *preset_limits("paper", stand_in.dataset);
    if (const std::optional<PoseLimits> chosen = preset_limits(preset, stand_in.dataset)) limits = *chosen;
    CaseGroup group{
        .name = name,
        .provenance = fmt::format("synthetic stand-in for {} {}, not its data", stand_in.dataset, stand_in.sequence),
        .cases = {}};
    for (std::uint32_t pair = 0; pair < pairs; ++pair) {
      group.cases.push_back({.name = fmt::format("{}", pair),
                             .seed = seed + pair,
                             .limits = limits,
                             .load = [&stand_in, seed, pair]() -> CaseData {
                               return {synth::stand_in_problem(stand_in, seed, pair), stand_in.noise_bound};
                             }});
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

std::vector<CaseGroup> noise_groups(const NoiseCells& cells) {
  SweepOptions checked;
  checked.points = {cells.points};
  checked.outlier_ratios = cells.outlier_ratios;
  checked.sigmas = cells.sigmas;
  checked.trials = cells.trials;
  validate(checked);

  std::vector<CaseGroup> groups;
  for (const double ratio : cells.outlier_ratios) {
    CaseGroup group{
        .name = fmt::format("noise {:.4g} %", 100.0 * ratio),
        .provenance = fmt::format("synthetic, the noise study's cube with {:.4g} % outliers", 100.0 * ratio),
        .cases = {}};
    for (std::uint32_t trial = 0; trial < cells.trials; ++trial) {
      for (const double sigma : cells.sigmas) {
        const synth::NoiseStudyOptions problem{.correspondences = cells.points,
                                               .outlier_ratio = ratio,
                                               .sigma = sigma,
                                               .seed = cells.seed,
                                               .trial = trial,
                                               .scale = cells.scale};
        group.cases.push_back({.name = fmt::format("sigma {:g} trial {}", sigma, trial),
                               .seed = cells.seed + trial,
                               .load = [problem]() -> CaseData {
                                 return {synth::noise_study_problem(problem), synth::noise_study_bound(problem.sigma)};
                               }});
      }
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

}  // namespace consimd::studies
