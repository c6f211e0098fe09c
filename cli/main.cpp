#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/kernels/isa.hpp>

#include <consimd/studies/build_info.hpp>
#include "commands.hpp"
#include "standard_streams.hpp"

namespace {

using namespace consimd::cli;

int fail(std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  tell("consimd: {}\n", message);
  return kBadInput;
}

/// An empty number is a variable of a shell that is not set: CLI11 takes it as if the option were not given.
void refuse_empty_numbers(CLI::App& app) {
  for (CLI::App* command : app.get_subcommands(nullptr)) {
    for (CLI::Option* option : command->get_options()) {
      const std::string type = option->get_type_name();
      if (type != "FLOAT" && type != "INT" && type != "UINT") continue;
      option->check(CLI::Validator(
          [](std::string& value) { return std::string(value.empty() ? "is empty, expected a number" : ""); }, ""));
    }
  }
}

/// Parses and does what the arguments say, help and version included. Throws CLI::ParseError on wrong usage.
int run_command(CLI::App& app, int argc, char** argv, const Action& run) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    std::ostringstream text;
    app.exit(help_or_version, text);
    fmt::print("{}", text.str());
    return kSuccess;
  }
  return run();
}

}  // namespace

int main(int argc, char** argv) {
  occupy_standard_descriptors();
  CLI::App app("Correspondence-based 3D registration on vectorised consensus kernels.", "consimd");
  app.set_version_flag("--version", fmt::format("consimd {}", consimd::studies::build_info().version));
  app.require_subcommand(1);
  std::vector<std::string_view> isas;
  for (const consimd::Isa isa : consimd::known_isas()) isas.push_back(to_string(isa));
  app.footer(
      fmt::format("Environment:\n"
                  "  CONSIMD_ISA  the instruction set to run on: {} (default: the widest found; same results)\n"
                  "Examples:\n"
                  "  consimd sweep\n"
                  "  consimd compare\n"
                  "  consimd generate --outliers 0.95 --out problem\n"
                  "  consimd register source.pcd target.pcd\n"
                  "  consimd register problem/correspondences.txt --noise-bound 3 --truth problem/pose.txt\n"
                  "'consimd COMMAND --help' explains a command.",
                  fmt::join(isas, ", ")));
  Action run;
  add_register_command(app, run);
  add_match_command(app, run);
  add_sweep_command(app, run);
  add_merge_command(app, run);
  add_compare_command(app, run);
  add_generate_command(app, run);
  add_info_command(app, run);
  refuse_empty_numbers(app);
  try {
    const int code = run_command(app, argc, argv, run);
    flush_standard_output();
    return code;
  } catch (const CLI::ParseError& error) {
    if (!app.get_subcommands().empty()) return fail(error.what());
    return fail(app.remaining_size() == 0
                    ? "expected a command; see 'consimd --help'"
                    : fmt::format("unknown command '{}'; see 'consimd --help'", app.remaining().front()));
  } catch (const std::bad_alloc&) {
    return fail("out of memory");
  } catch (const std::exception& error) {
    // What a printing function throws does not say where to.
    return fail(std::ferror(stdout) != 0 ? "cannot write to the standard output" : error.what());
  }
}
