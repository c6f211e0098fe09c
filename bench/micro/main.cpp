// Benchmarks of the kernels, of the graph stages and of whole registrations; takes Google Benchmark's arguments.
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <consimd/kernels/isa.hpp>

#include <consimd/studies/build_info.hpp>
#include "bench_options.hpp"
#include "clock_benchmark.hpp"
#include "cloud_benchmarks.hpp"
#include "front_end_benchmarks.hpp"
#include "graph_benchmarks.hpp"
#include "kernel_benchmarks.hpp"
#include "registration_benchmarks.hpp"

namespace {

/// Ours beside the library's own context: its "library_build_type" is about Google Benchmark, which Debian builds as
/// debug.
void describe_build() {
  const auto context = [](const char* key, std::string_view value) {
    benchmark::AddCustomContext(key, std::string(value));
  };
  const consimd::studies::BuildInfo& build = consimd::studies::build_info();
  const consimd::studies::Machine machine = consimd::studies::this_machine();
  context("consimd_version", build.version);
  context("consimd_commit", build.commit);
  context("consimd_build_type", build.build_type);
  context("consimd_compiler", build.compiler);
  context("consimd_flags", build.flags);
  std::string isas;
  for (const consimd::Isa isa : consimd::supported_isas()) isas.append(isas.empty() ? "" : ", ").append(to_string(isa));
  context("consimd_isas", isas);
  context("consimd_default_isa", to_string(consimd::active_isa()));
  context("consimd_threads", "1");
  context("cpu", machine.cpu);
  context("system", machine.system);
}

/// The library warns of itself on the standard error, in words that seem to be about the program.
void explain_warning() {
  std::fprintf(stderr,
               "consimd_bench: consimd is built as %s. A warning \"Library was built as DEBUG\" below is about Google "
               "Benchmark alone, which Debian builds so.\n",
               std::string(consimd::studies::build_info().build_type).c_str());
}

}  // namespace

int main(int argc, char** argv) try {
  // Some 400 benchmarks: a tenth of a second each unless told otherwise. Later arguments override earlier ones.
  std::string min_time = "--benchmark_min_time=0.1";
  std::vector<char*> arguments{argv[0], min_time.data()};
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  const consimd::bench::BenchOptions options = consimd::bench::take_options(arguments);
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  benchmark::Initialize(&count, arguments.data(), consimd::bench::print_help);
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  describe_build();
  consimd::bench::register_clock_benchmark();
  consimd::bench::register_kernel_benchmarks(options);
  consimd::bench::register_graph_benchmarks();
  consimd::bench::register_cloud_benchmarks();
  consimd::bench::register_front_end_benchmarks();
  consimd::bench::register_registration_benchmarks();
  explain_warning();
  if (benchmark::RunSpecifiedBenchmarks() == 0) {
    throw std::invalid_argument("no benchmark matches the filter; --benchmark_list_tests lists all");
  }
  benchmark::Shutdown();
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "consimd_bench: %s\n", error.what());
  return 2;
}
