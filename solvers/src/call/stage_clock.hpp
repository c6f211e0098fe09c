// Wall time of a solver's stages.
#pragma once

#include <chrono>

namespace consimd::detail {

/// Adds the time from its construction to its destruction to `seconds`.
class StageClock {
 public:
  explicit StageClock(double& seconds) noexcept : seconds_(seconds) {}
  ~StageClock() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace consimd::detail
