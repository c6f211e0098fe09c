// On how many threads a piece of code runs, for callers who have no oneTBB themselves.
#pragma once

#include <functional>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Runs `body`, and what it calls of this library, on at most so many threads, the caller's among them: in an oneTBB
/// arena of its own, no larger than the machine has processors for. 0: in the arena that the caller is in. Throws
/// std::invalid_argument on a number below 0, and what `body` throws.
void run_on_threads(int threads, const std::function<void()>& body);

}  // namespace consimd
