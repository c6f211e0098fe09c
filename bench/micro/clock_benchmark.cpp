#include "clock_benchmark.hpp"

#include <cstdint>

#include <benchmark/benchmark.h>

namespace consimd::bench {

void register_clock_benchmark() {
  benchmark::RegisterBenchmark("clock", [](benchmark::State& state) {
    constexpr int kAdditions = 4096;
    std::uint64_t sum = 0;
    std::uint64_t step = 1;
    // The compiler must neither know the numbers nor merge the additions.
    asm volatile("" : "+r"(step));
    const auto add = [&] {
      sum += step;
      asm volatile("" : "+r"(sum));
    };
    for (auto _ : state) {
      for (int k = 0; k < kAdditions; k += 4) {
        add();
        add();
        add();
        add();
      }
    }
    state.SetItemsProcessed(state.iterations() * kAdditions);
    state.SetLabel("cycles");
  });
}

}  // namespace consimd::bench
