// What ends a search early: a limit of time, or the end of the call that waits for it.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <consimd/solvers/stop_condition.hpp>

#include "interruptible_call.hpp"

namespace consimd::python {

/// Throws std::invalid_argument unless it is None or a number above 0.
inline void require_time_limit(std::optional<double> seconds) {
  if (!seconds || *seconds > 0.0) return;
  throw std::invalid_argument("time_limit is " + std::to_string(*seconds) + ", expected seconds above 0, or None");
}

/// From now on; `interrupted` must outlive the search.
[[nodiscard]] inline StopCondition stop_of(std::optional<double> time_limit, const std::atomic<bool>& interrupted) {
  StopCondition stop = time_limit ? stop_after(*time_limit) : StopCondition{};
  stop.requested = &interrupted;
  return stop;
}

/// `interruptible_result` of work(interrupted): the flag is set when the caller no longer waits, so that the search
/// ends soon after.
template <typename Result, typename Work>
[[nodiscard]] Result stoppable_result(const Work& work) {
  const auto interrupted = std::make_shared<std::atomic<bool>>(false);
  try {
    return interruptible_result<Result>([work, interrupted] { return work(*interrupted); });
  } catch (...) {
    *interrupted = true;
    throw;
  }
}

}  // namespace consimd::python
