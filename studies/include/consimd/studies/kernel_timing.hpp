// Kernels of anybody's, checked and timed on the workloads of consimd's own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/kernel_workload.hpp>
#include <consimd/studies/text_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// What a kernel gives for a workload: counts, or the bits of its floats and words.
using KernelOutput = std::vector<std::uint32_t>;

/// One call. It fills `output`, which comes with what the last call left in it.
using KernelCall = std::function<void(const KernelWorkload& workload, KernelOutput& output)>;

struct KernelVariant {
  std::string name;  ///< such as the instruction set
  KernelCall call;
};

struct TimedKernel {
  std::string name;
  std::string item;                                    ///< what the rate counts, plural: "pairs"
  std::function<double(const KernelWorkload&)> items;  ///< of one call
  KernelCall reference;                                ///< the specification, a plain loop; timed as "scalar"
  std::vector<KernelVariant> variants;
  /// Whether an output is right. Empty: it must be the reference's, word for word.
  std::function<bool(const KernelOutput& output, const KernelOutput& reference)> agrees = {};
};

struct KernelRate {
  std::string kernel;
  std::string item;
  std::size_t size = 0;  ///< correspondences
  std::string variant;
  double items_per_second = 0.0;  ///< median of the repetitions
  double lowest = 0.0;
  double highest = 0.0;
};

struct KernelTimingOptions {
  std::vector<std::size_t> sizes = {1'000, 3'000, 10'000};  ///< correspondences
  std::size_t batch = KernelWorkload::kBatch;               ///< hypotheses at once
  double seconds = 0.05;                                    ///< least time of a repetition
  std::size_t repetitions = 3;  ///< one after the other over all variants, so that a slow moment hits all alike
};

/// Times the reference and the variants of every kernel on every size, by the processor time of this process: nothing
/// else should run in it. Before a variant is timed its output is held against the reference's. Throws
/// std::runtime_error that names kernel, variant and size where they do not agree, and std::invalid_argument on an
/// empty call, a name that is there twice, or a bad option.
[[nodiscard]] std::vector<KernelRate> time_kernels(std::span<const TimedKernel> kernels,
                                                   const KernelTimingOptions& options = {});

/// The table of one size as "./dev bench --report" writes it: a row a kernel, a column a variant, in 10^9 items a
/// second, then what the last variant of the row makes of each of the others' rates. Without rates of the size it has
/// no rows.
[[nodiscard]] TextTable kernel_rate_table(std::span<const KernelRate> rates, std::size_t size);

}  // namespace studies
}  // namespace consimd
