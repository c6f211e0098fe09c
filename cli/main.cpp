#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/kernels/isa.hpp>

#include <consimd/studies/build_info.hpp>
#include "commands.hpp"

namespace {

int fail(std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  fmt::print(stderr, "consimd: {}\n", message);
  return consimd::cli::kBadInput;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace consimd::cli;
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
                  "  consimd register problem/correspondences.txt --noise-bound 3 --truth problem/pose.txt\n"
                  "'consimd COMMAND --help' explains a command.",
                  fmt::join(isas, ", ")));
  Action run;
  add_register_command(app, run);
  add_sweep_command(app, run);
  add_merge_command(app, run);
  add_compare_command(app, run);
  add_generate_command(app, run);
  add_info_command(app, run);
  try {
    app.parse(argc, argv);
    const int code = run();
    return std::fflush(stdout) == 0 ? code : fail("cannot write to the standard output");
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help or version
    if (!app.get_subcommands().empty()) return fail(error.what());
    return fail(app.remaining_size() == 0
                    ? "expected a command; see 'consimd --help'"
                    : fmt::format("unknown command '{}'; see 'consimd --help'", app.remaining().front()));
  } catch (const std::bad_alloc&) {
    return fail("out of memory");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}
