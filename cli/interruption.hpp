// Ctrl-C and kill as a wish to stop, not as the end.
#pragma once

namespace consimd::cli {

/// While one lives, the first SIGINT or SIGTERM is only noted; a second one ends the process as usual. One at a time.
class InterruptionGuard {
 public:
  InterruptionGuard();
  ~InterruptionGuard();
  InterruptionGuard(const InterruptionGuard&) = delete;
  InterruptionGuard& operator=(const InterruptionGuard&) = delete;

  /// From any thread.
  [[nodiscard]] static bool requested() noexcept;
};

}  // namespace consimd::cli
