#include "family_arguments.hpp"

#include <cstddef>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/synth/problem_families.hpp>

#include "text/words.hpp"

namespace consimd::cli {
namespace {

std::size_t whole_number_in(std::string_view text) {
  if (const auto value = text::number_in<std::size_t>(text)) return *value;
  throw std::invalid_argument(fmt::format("expected a whole number, got '{}'", text));
}

/// The values of a list "v1,v2,...".
template <typename Parse>
auto values_of(std::string_view option, std::string_view list, const Parse& parse) {
  std::vector<decltype(parse(list))> values;
  try {
    for (const std::string_view part : text::split(list, ',')) values.push_back(parse(part));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", option, error.what()));
  }
  return values;
}

}  // namespace

void add_condition_arguments(CLI::App& command, ConditionArguments& arguments) {
  command.add_option("--points", arguments.points, "Correspondences of a problem: a list")->capture_default_str();
  command.add_option("--family", arguments.families, "Families of problems: a list; see below")->capture_default_str();
  command
      .add_option(
          "--scale", arguments.scales,
          "known, unknown, or a list of the two: an unknown scale of the source, from 0.5 to 2, is to be found as well")
      ->capture_default_str();
  command
      .add_option("--bound-factor", arguments.bound_factors,
                  "Noise bounds that solvers are given, over 3 sigma: a list of numbers > 0, and estimated, where they "
                  "are given none")
      ->capture_default_str();
  command
      .add_option("--no-pose", arguments.no_pose,
                  "Share of the problems that have no true pose, in [0, 1): poses that are found there are wrong")
      ->capture_default_str();
}

void set_conditions(studies::SweepOptions& study, const ConditionArguments& arguments) {
  study.points = values_of("--points", arguments.points, whole_number_in);
  study.families = values_of("--family", arguments.families,
                             [](std::string_view name) { return std::string(synth::problem_family(name).name); });
  study.scales = values_of("--scale", arguments.scales, studies::scale_knowledge_by_name);
  study.bound_factors = values_of("--bound-factor", arguments.bound_factors, studies::parse_bound_factor);
  study.no_pose = arguments.no_pose;
}

std::string family_lines() {
  std::string lines;
  for (const synth::ProblemFamily& family : synth::problem_families()) {
    lines += fmt::format("  {:<19} {}\n", family.name, family.sentence);
  }
  return lines;
}

std::string bound_text(const studies::SweepOptions& study) {
  if (study.bound_factors == std::vector{studies::BoundFactor(1.0)}) return "noise bound 3 sigma";
  std::vector<std::string> factors;
  factors.reserve(study.bound_factors.size());
  for (const studies::BoundFactor& factor : study.bound_factors) factors.push_back(studies::to_string(factor));
  return fmt::format("noise bound 3 sigma times {}", fmt::join(factors, ", "));
}

}  // namespace consimd::cli
