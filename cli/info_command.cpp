#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/solver.hpp>

#include <consimd/studies/build_info.hpp>
#include "commands.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

int run_info(bool json) {
  const studies::BuildInfo& build = studies::build_info();
  const studies::Machine machine = studies::this_machine();
  std::vector<std::string_view> isas;
  for (const Isa isa : supported_isas()) isas.push_back(to_string(isa));
  std::vector<std::string_view> solver_names;
  for (const SolverInfo& solver : solvers()) solver_names.push_back(solver.name);
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
                                         {"solvers", solver_names}};
    fmt::print("{}\n", info.dump(2));
    return kSuccess;
  }
  fmt::print("version   {} (commit {})\n", build.version, build.commit);
  fmt::print("compiler  {}, {} build, flags {}\n", build.compiler, build.build_type, build.flags);
  fmt::print("machine   {}, {}\n", machine.cpu, machine.system);
  fmt::print("isa       {} (found: {}; choose with CONSIMD_ISA)\n", isa, fmt::join(isas, ", "));
  fmt::print("threads   {}\n", available_threads());
  for (const SolverInfo& solver : solvers()) fmt::print("solver    {}: {}\n", solver.name, solver.description);
  return kSuccess;
}

}  // namespace

void add_info_command(CLI::App& app, Action& run) {
  CLI::App* command = app.add_subcommand("info", "Print version, compiler, instruction sets, threads and solvers");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "As JSON");
  command->footer("Exit code: 0, or 2 when CONSIMD_ISA names an instruction set that is unknown or not found here.");
  command->callback([&run, json] { run = [json] { return run_info(*json); }; });
}

}  // namespace consimd::cli
