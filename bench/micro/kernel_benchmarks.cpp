#include "kernel_benchmarks.hpp"

#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <consimd/kernels/isa.hpp>

#include "kernels.hpp"

namespace consimd::bench {
namespace {

Outcome reference_outcome(const Kernel& kernel, const Workload& w) {
  set_active_isa(Isa::scalar);
  Outcome outcome;
  kernel.prepare(w)(outcome);
  return outcome;
}

using Agrees = bool (*)(const Outcome&, const Outcome& reference);

/// What a kernel is timed on.
struct Load {
  std::size_t size;
  std::size_t batch;
};

void measure(benchmark::State& state, const Kernel& kernel, Load load, Isa isa, PrepareCall prepare, Agrees agrees) {
  const Workload& w = workload(load.size, load.batch);
  const Outcome reference = reference_outcome(kernel, w);
  set_active_isa(isa);
  const Call call = prepare(w);
  Outcome outcome;
  call(outcome);
  if (!agrees(outcome, reference)) {
    state.SkipWithError("differs from the scalar reference");
    return;
  }
  for (auto _ : state) {
    call(outcome);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kernel.items(w)));
  state.SetLabel(std::string(kernel.item));
}

void add(const Kernel& kernel, Load load, std::string_view variant, Isa isa, PrepareCall prepare, Agrees agrees) {
  std::string name = fmt::format("{}/{}/{}", kernel.name, load.size, variant);
  if (load.batch != studies::KernelWorkload::kBatch) name += fmt::format("/batch:{}", load.batch);
  benchmark::RegisterBenchmark(
      name.c_str(), [=, &kernel](benchmark::State& state) { measure(state, kernel, load, isa, prepare, agrees); });
}

}  // namespace

void register_kernel_benchmarks(const BenchOptions& options) {
  for (const Kernel& kernel : kernels()) {
    for (const std::size_t size : options.sizes) {
      if (size > kernel.largest_size) continue;
      for (const std::size_t batch : options.batches) {
        // What takes no batch is timed once.
        const Load load{size, takes_batches(kernel) ? batch : studies::KernelWorkload::kBatch};
        if (!takes_batches(kernel) && batch != options.batches.front()) continue;
        for (const Isa isa : options.isas) add(kernel, load, to_string(isa), isa, kernel.prepare, identical);
        for (const Baseline& baseline : baselines()) {
          if (baseline.kernel == kernel.name) add(kernel, load, baseline.name, active_isa(), baseline.prepare, close);
        }
      }
    }
  }
}

}  // namespace consimd::bench
