#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/registry.hpp>

#include <consimd/studies/build_info.hpp>
#include "commands.hpp"
#include "option_json.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

int run_info(bool json) {
  const studies::BuildInfo& build = studies::build_info();
  const studies::Machine machine = studies::this_machine();
  std::vector<std::string_view> isas;
  for (const Isa isa : supported_isas()) isas.push_back(to_string(isa));
  const std::string_view isa = to_string(active_isa());

  if (json) {
    const nlohmann::ordered_json info = {{"version", build.version},
                                         {"commit", build.commit},
                                         {"compiler", build.compiler},
                                         {"flags", build.flags},
                                         {"build_type", build.build_type},
                                         {"cpu", machine.cpu},
                                         {"system", machine.system},
                                         {"isas", isas},
                                         {"isa", isa},
                                         {"threads", available_threads()},
                                         {"solvers", solver_names()}};
    fmt::print("{}\n", info.dump(2));
    return kSuccess;
  }
  fmt::print("version   {} (commit {})\n", build.version, build.commit);
  fmt::print("compiler  {}, {} build, flags {}\n", build.compiler, build.build_type, build.flags);
  fmt::print("machine   {}, {}\n", machine.cpu, machine.system);
  fmt::print("isa       {} (found: {}; choose with CONSIMD_ISA)\n", isa, fmt::join(isas, ", "));
  fmt::print("threads   {}\n", available_threads());
  for (const std::string& name : solver_names()) {
    fmt::print("solver    {}: {}\n", name, SolverChoice(name).description());
  }
  fmt::print("          'consimd info --solver NAME' lists the options of one\n");
  return kSuccess;
}

nlohmann::ordered_json to_json(const SolverChoice& choice) {
  const Solver& solver = choice.solver();
  nlohmann::ordered_json options = nlohmann::ordered_json::array();
  for (const SolverOption& option : solver.options) {
    options.push_back({{"name", option.name},
                       {"value", option_json(choice.value(option.name))},
                       {"unit", option.unit},
                       {"expected", expectation(option)},
                       {"meaning", option.meaning}});
  }
  nlohmann::ordered_json presets = nlohmann::ordered_json::array();
  for (const Preset& preset : solver.presets) {
    presets.push_back(
        {{"name", preset.name}, {"description", preset.description}, {"options", options_json(preset.settings)}});
  }
  return {{"name", choice.name()},
          {"solver", solver.name},
          {"description", choice.description()},
          {"estimates_scale", solver.estimates_scale()},
          {"needs", solver.needs},
          {"memory", solver.memory},
          {"stops_early", solver.stops_early},
          {"advice", solver.advice},
          {"presets", presets},
          {"options", options}};
}

std::string settings_text(const std::vector<OptionSetting>& settings) {
  std::string text;
  for (const OptionSetting& setting : settings) {
    text += fmt::format("{}{}={}", text.empty() ? "" : ", ", setting.name, to_string(setting.value));
  }
  return text;
}

/// The options with their values as the choice has them.
int run_solver_info(const std::string& text, bool json) {
  const SolverChoice choice(text);
  const Solver& solver = choice.solver();
  if (json) {
    fmt::print("{}\n", to_json(choice).dump(2));
    return kSuccess;
  }
  fmt::print("solver       {}: {}\n", choice.name(), choice.description());
  fmt::print("needs        {}\n", solver.needs.empty() ? "nothing" : solver.needs);
  fmt::print("memory       {}\n", solver.memory);
  fmt::print("stops early  {}\n", solver.stops_early);
  fmt::print("scale        {}\n", solver.estimates_scale() ? "known or unknown" : "known");
  fmt::print("when         {}\n", solver.advice);
  for (const Preset& preset : solver.presets) {
    fmt::print("preset       {}: {} ({})\n", preset.name, preset.description, settings_text(preset.settings));
  }
  fmt::print("options      --option NAME=VALUE, or --solver {}:NAME=VALUE; values as they are without\n",
             choice.name());
  for (const SolverOption& option : solver.options) {
    fmt::print("  {}={}\n", option.name, to_string(choice.value(option.name)));
    fmt::print("      {}{}{}\n", option.unit, option.unit.empty() ? "" : ": ", option.meaning);
    fmt::print("      {}\n", expectation(option));
  }
  return kSuccess;
}

struct Options {
  std::string solver;
  bool json = false;
};

}  // namespace

void add_info_command(CLI::App& app, Action& run) {
  CLI::App* command = app.add_subcommand(
      "info", "Print version, compiler, instruction sets, threads and solvers, or the options of a solver");
  auto options = std::make_shared<Options>();
  CLI::Option* solver = command->add_option("--solver", options->solver, "Tell of this solver and its options instead");
  command->add_flag("--json", options->json, "As JSON");
  command->footer(
      "Exit code: 0, or 2 when CONSIMD_ISA names an instruction set that is unknown or not found here, or there is no\n"
      "such solver.\n"
      "Examples:\n"
      "  consimd info\n"
      "  consimd info --solver ransac");
  command->callback([&run, options, solver] {
    run = [options, one = solver->count() > 0] {
      return one ? run_solver_info(options->solver, options->json) : run_info(options->json);
    };
  });
}

}  // namespace consimd::cli
