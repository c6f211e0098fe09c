// The number of threads: the command owns the process, so it alone may limit oneTBB.
#pragma once

#include <utility>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <CLI/CLI.hpp>

#include "option_checks.hpp"

namespace consimd::cli {

[[nodiscard]] inline int available_threads() { return tbb::info::default_concurrency(); }

inline void add_threads_option(CLI::App& command, int& threads) {
  threads = available_threads();
  command.add_option("--threads", threads, "Threads to use; the results do not depend on it")
      ->check(whole_number(1, 1024))
      ->capture_default_str();
}

/// Runs `body` in an arena of that many threads.
template <typename Body>
auto with_threads(int threads, Body&& body) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute(std::forward<Body>(body));
}

}  // namespace consimd::cli
