#include <consimd/solvers/threads.hpp>

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "call/option_checks.hpp"

namespace consimd {

void run_on_threads(int threads, const std::function<void()>& body) {
  if (threads == 0) return body();
  if (threads < 0) detail::reject_option("threads", threads, "a number above 0, or 0 for the caller's arena");
  tbb::task_arena arena(std::min(threads, tbb::info::default_concurrency()));
  arena.execute(body);
}

}  // namespace consimd
