// What ends a search before it is through.
#pragma once

#include <atomic>
#include <chrono>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// A flag of the caller's and a point in time; by default neither, and results are the same on every machine. Searches
/// look at both between their batches, which take a millisecond or so. What was found until then is judged as always,
/// so that a call returns some milliseconds after the deadline, and says so (see Registration::stopped).
struct StopCondition {
  /// Set by any thread, for instance by a std::stop_callback or a handler of signals; it must outlive the call.
  const std::atomic<bool>* requested = nullptr;
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();

  [[nodiscard]] bool met() const noexcept {
    return (requested != nullptr && requested->load(std::memory_order_relaxed)) ||
           (deadline != std::chrono::steady_clock::time_point::max() && std::chrono::steady_clock::now() >= deadline);
  }
};

/// The condition that so many seconds from now have passed; never where they are NaN or a century and more.
[[nodiscard]] StopCondition stop_after(double seconds) noexcept;

}  // namespace consimd
