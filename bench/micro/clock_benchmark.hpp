// Registers a benchmark of the processor's clock, which bounds in cycles are turned into rates with.
#pragma once

namespace consimd::bench {

/// clock: additions, each of which waits for the one before and takes a cycle; its rate is the clock's.
void register_clock_benchmark();

}  // namespace consimd::bench
