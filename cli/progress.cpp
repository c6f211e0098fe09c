#include "progress.hpp"

#include <cmath>

#include <fmt/format.h>

#include "standard_streams.hpp"

namespace consimd::cli {
namespace {

using namespace std::chrono_literals;

constexpr auto kTerminalInterval = 100ms;
constexpr auto kPlainInterval = 10s;
constexpr std::size_t kBarWidth = 20;  // the whole line stays below 80 characters

std::string duration(double seconds) {
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

}  // namespace

Progress::Progress(std::size_t total, std::size_t done, std::string_view steps)
    : total_(total),
      done_before_(done),
      done_(done),
      steps_(steps),
      terminal_(error_stream_is_terminal()),
      start_(Clock::now()),
      shown_(start_) {
  if (terminal_) show(start_);
}

Progress::~Progress() {
  if (line_open_) tell("\n");
}

void Progress::step() {
  ++done_;
  const Clock::time_point now = Clock::now();
  if (done_ == total_ ||
      now - shown_ >= (terminal_ ? Clock::duration(kTerminalInterval) : Clock::duration(kPlainInterval))) {
    show(now);
  }
}

void Progress::show(Clock::time_point now) {
  shown_ = now;
  if (!terminal_) {
    tell("{}\n", status(now));
    return;
  }
  const std::size_t filled = kBarWidth * done_ / total_;
  tell("\r[{:=<{}}{:{}}] {}\x1b[K", "", filled, "", kBarWidth - filled, status(now));
  line_open_ = true;
}

std::string Progress::status(Clock::time_point now) const {
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  std::string text = fmt::format("{:3} % {}/{} {}, {}", 100 * done_ / total_, done_, total_, steps_, duration(elapsed));
  const std::size_t here = done_ - done_before_;
  if (here == 0 || done_ == total_) return text;
  return fmt::format("{}, {} left", text,
                     duration(elapsed / static_cast<double>(here) * static_cast<double>(total_ - done_)));
}

}  // namespace consimd::cli
