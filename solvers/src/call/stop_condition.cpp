#include <consimd/solvers/stop_condition.hpp>

#include <algorithm>

namespace consimd {

StopCondition stop_after(double seconds) noexcept {
  using Clock = std::chrono::steady_clock;
  constexpr double kCentury = 100.0 * 365.25 * 86'400.0;  // the clock counts nanoseconds up to 292 years
  StopCondition stop;
  if (!(seconds < kCentury)) return stop;
  stop.deadline =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::max(seconds, 0.0)));
  return stop;
}

}  // namespace consimd
