#include "kernel_benchmarks.hpp"

#include <string>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <consimd/kernels/isa.hpp>

#include "kernels.hpp"

namespace consimd::bench {
namespace {

constexpr std::size_t kSizes[] = {1'000, 3'000, 10'000, 100'000};

Outcome reference_outcome(const Kernel& kernel, const Workload& w) {
  set_active_isa(Isa::scalar);
  Outcome outcome;
  kernel.prepare(w)(outcome);
  return outcome;
}

using Agrees = bool (*)(const Outcome&, const Outcome& reference);

void measure(benchmark::State& state, const Kernel& kernel, std::size_t size, Isa isa, PrepareCall prepare,
             Agrees agrees) {
  const Workload& w = workload(size);
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

void add(const Kernel& kernel, std::size_t size, std::string_view variant, Isa isa, PrepareCall prepare,
         Agrees agrees) {
  const std::string name = fmt::format("{}/{}/{}", kernel.name, size, variant);
  benchmark::RegisterBenchmark(
      name.c_str(), [=, &kernel](benchmark::State& state) { measure(state, kernel, size, isa, prepare, agrees); });
}

}  // namespace

void register_kernel_benchmarks() {
  for (const Kernel& kernel : kernels()) {
    for (const std::size_t size : kSizes) {
      if (size > kernel.largest_size) continue;
      for (const Isa isa : supported_isas()) add(kernel, size, to_string(isa), isa, kernel.prepare, identical);
      for (const Baseline& baseline : baselines()) {
        if (baseline.kernel == kernel.name) add(kernel, size, baseline.name, active_isa(), baseline.prepare, close);
      }
    }
  }
}

}  // namespace consimd::bench
