// The kernels that are benchmarked, and the baselines beside them.
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>
#include <vector>

#include "outcome.hpp"
#include "workload.hpp"

namespace consimd::bench {

/// One call of a kernel or baseline on a workload. It owns its scratch memory, so that calls do not allocate.
using Call = std::function<void(Outcome&)>;
using PrepareCall = Call (*)(const Workload&);

struct Kernel {
  std::string_view name;
  std::string_view item;                  ///< what the rate counts, plural
  std::size_t (*items)(const Workload&);  ///< of one call
  std::size_t largest_size;               ///< correspondences
  PrepareCall prepare;                    ///< runs on the active instruction set
};

[[nodiscard]] const std::vector<Kernel>& kernels();

/// Whether its work is that of a batch of hypotheses.
[[nodiscard]] bool takes_batches(const Kernel& kernel);

struct Baseline {
  std::string_view name;    ///< "loop", "textbook" (loop_baseline.hpp) or "eigen" (eigen_baseline.hpp)
  std::string_view kernel;  ///< what it is held against
  PrepareCall prepare;
};

[[nodiscard]] const std::vector<Baseline>& baselines();

}  // namespace consimd::bench
