// What every target is linked with: an input that takes a minute of processor time is a finding. The limit of libFuzzer
// is by the clock, which tells of slow inputs where a machine is only busy.
#include <signal.h>
#include <sys/time.h>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace {

constexpr int kSeconds = 60;  // of all threads

extern "C" void end_slow_input(int /*signal*/) {
  std::fputs("an input took a minute of processor time\n", stderr);
  std::abort();
}

}  // namespace

// The linker calls these in place of the target's function, and that function (--wrap).
extern "C" int __real_LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int __wrap_LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bool is_set = signal(SIGPROF, end_slow_input) != SIG_ERR;
  constexpr itimerval kLimit = {.it_interval = {}, .it_value = {.tv_sec = kSeconds, .tv_usec = 0}};
  if (!is_set || setitimer(ITIMER_PROF, &kLimit, nullptr) != 0) std::abort();
  return __real_LLVMFuzzerTestOneInput(data, size);
}
