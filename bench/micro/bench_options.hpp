// What consimd_bench takes besides Google Benchmark's arguments.
#pragma once

#include <cstddef>
#include <vector>

#include <consimd/kernels/isa.hpp>
#include <consimd/studies/kernel_workload.hpp>

namespace consimd::bench {

/// Of the kernels' benchmarks.
struct BenchOptions {
  std::vector<std::size_t> sizes = {1'000, 3'000, 10'000, 100'000};      ///< correspondences
  std::vector<std::size_t> batches = {studies::KernelWorkload::kBatch};  ///< hypotheses at once
  std::vector<Isa> isas;                                                 ///< defaults to all that the machine has
};

/// Takes `--sizes`, `--batch` and `--isas`, each with its value behind "=" or as the next argument, out of the
/// arguments; the first is the program. Throws std::invalid_argument on a bad value.
[[nodiscard]] BenchOptions take_options(std::vector<char*>& arguments);

/// Prints them, then Google Benchmark's.
void print_help();

}  // namespace consimd::bench
