#include "interruption.hpp"

#include <signal.h>
#include <atomic>

namespace consimd::cli {
namespace {

std::atomic<bool> noted = false;
static_assert(std::atomic<bool>::is_always_lock_free);  // else a signal handler may not touch it

void install(void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

}  // namespace

InterruptionGuard::InterruptionGuard() {
  noted = false;
  install([](int) { noted = true; }, SA_RESTART | static_cast<int>(SA_RESETHAND));
}

InterruptionGuard::~InterruptionGuard() { install(SIG_DFL, 0); }

bool InterruptionGuard::requested() noexcept { return noted; }

}  // namespace consimd::cli
