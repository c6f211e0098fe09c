// How far a long run is, on the standard error stream.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace consimd::cli {

/// A bar with the time left on a terminal, a plain line now and then elsewhere. Not thread-safe.
class Progress {
 public:
  /// `done` steps of `total` were made before; `steps` says what they are, in one or two short words.
  Progress(std::size_t total, std::size_t done, std::string_view steps);
  /// Leaves the bar's line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void step();

 private:
  using Clock = std::chrono::steady_clock;

  void show(Clock::time_point now);
  [[nodiscard]] std::string status(Clock::time_point now) const;

  std::size_t total_;
  std::size_t done_before_;
  std::size_t done_;
  std::string_view steps_;
  bool terminal_;
  bool line_open_ = false;
  Clock::time_point start_;
  Clock::time_point shown_;
};

}  // namespace consimd::cli
