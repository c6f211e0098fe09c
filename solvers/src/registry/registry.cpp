#include <consimd/solvers/registry.hpp>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "text/words.hpp"

namespace consimd {
namespace {

constexpr std::string_view kEstimateScale = "estimate_scale";

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

OptionSetting* find(std::vector<OptionSetting>& settings, std::string_view option) {
  const auto found = std::ranges::find(settings, option, &OptionSetting::name);
  return found == settings.end() ? nullptr : &*found;
}

}  // namespace

bool Solver::estimates_scale() const {
  return std::ranges::any_of(options, [](const SolverOption& option) { return option.name == kEstimateScale; });
}

std::vector<std::string> solver_names(std::span<const Solver> among) {
  std::vector<std::string> names;
  for (const Solver& solver : among) {
    names.push_back(solver.name);
    for (const Preset& preset : solver.presets) names.push_back(preset.name);
  }
  return names;
}

SolverChoice::SolverChoice(std::string_view text, std::span<const Solver> among)
    : name_(text.substr(0, text.find(':'))) {
  for (const Solver& solver : among) {
    if (solver.name == name_) solver_ = &solver;
    for (const Preset& preset : solver.presets) {
      if (preset.name != name_) continue;
      solver_ = &solver;
      preset_ = &preset;
      settings_ = preset.settings;
    }
  }
  if (solver_ == nullptr) {
    throw std::invalid_argument("solver is '" + name_ + "', expected one of: " + joined(solver_names(among)));
  }
  const std::vector<std::string_view> parts = text::split(text, ':');
  for (std::size_t k = 1; k < parts.size(); ++k) set(parts[k]);
}

void SolverChoice::set(std::string_view option, OptionValue value) {
  require_allowed(option_named(solver_->options, option, "solver '" + name_ + "'"), value);
  if (std::ranges::find(given_, option) != given_.end()) {
    throw std::invalid_argument("option '" + std::string(option) + "' of solver '" + name_ + "' is given twice");
  }
  given_.emplace_back(option);
  if (OptionSetting* preset = find(settings_, option)) {
    preset->value = std::move(value);
  } else {
    settings_.push_back({std::string(option), std::move(value)});
  }
}

void SolverChoice::set(std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string_view name = assignment.substr(0, equals);
  const SolverOption& option = option_named(solver_->options, name, "solver '" + name_ + "'");
  if (equals == std::string_view::npos) {
    throw std::invalid_argument("option '" + std::string(name) + "' has no value, expected " + option.name + "=" +
                                to_string(option.default_value) + " or another value");
  }
  set(name, parse_option(option, assignment.substr(equals + 1)));
}

const std::string& SolverChoice::description() const noexcept {
  return preset_ != nullptr ? preset_->description : solver_->description;
}

std::vector<OptionSetting> SolverChoice::given() const {
  std::vector<OptionSetting> result;
  for (const SolverOption& option : solver_->options) {
    if (std::ranges::find(given_, option.name) != given_.end()) result.push_back({option.name, value(option.name)});
  }
  return result;
}

std::string SolverChoice::label() const {
  std::string text = name_;
  for (const OptionSetting& setting : given()) {
    text.append(":").append(setting.name).append("=").append(to_string(setting.value));
  }
  return text;
}

const OptionValue& SolverChoice::value(std::string_view option) const {
  const auto set = std::ranges::find(settings_, option, &OptionSetting::name);
  if (set != settings_.end()) return set->value;
  return option_named(solver_->options, option, "solver '" + name_ + "'").default_value;
}

bool SolverChoice::estimates_scale() const {
  return solver_->estimates_scale() && value(kEstimateScale) == OptionValue(true);
}

Registration SolverChoice::run(const Correspondences& correspondences, const SolverTask& task) const {
  return solver_->run(correspondences, task, settings_);
}

void require_scale_estimation(const SolverChoice& choice, std::span<const Solver> among) {
  if (choice.solver().estimates_scale()) return;
  std::vector<std::string> able;
  for (const Solver& solver : among) {
    if (solver.estimates_scale()) able.push_back(solver.name);
  }
  throw std::invalid_argument("estimate_scale: solver '" + choice.name() +
                              "' needs a known scale, expected one of: " + joined(able));
}

}  // namespace consimd
