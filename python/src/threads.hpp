// How many threads a call takes.
#pragma once

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>

#include <tbb/info.h>
#include <tbb/task_arena.h>

namespace consimd::python {

/// Runs `body` on at most so many threads, all that the process may use unless a number is given. `threads`: as
/// `checked_threads` returned it.
template <typename Body>
auto with_threads(std::optional<int> threads, const Body& body) {
  if (!threads) return body();
  tbb::task_arena arena(*threads);
  return arena.execute(body);
}

/// Never more than the process may use: nothing would be gained. Throws std::invalid_argument if the number is below 1.
[[nodiscard]] inline std::optional<int> checked_threads(std::optional<int> threads) {
  if (!threads) return threads;
  if (*threads < 1) {
    throw std::invalid_argument("threads is " + std::to_string(*threads) + ", expected at least 1, or None for all");
  }
  return std::min(*threads, tbb::info::default_concurrency());
}

}  // namespace consimd::python
