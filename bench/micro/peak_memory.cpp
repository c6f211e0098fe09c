#include "peak_memory.hpp"

#include <fstream>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace consimd::bench {
namespace {

/// Largest resident size since the last reset.
std::optional<std::size_t> peak_resident_bytes() {
  std::ifstream status("/proc/self/status");
  std::size_t kib = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:" && status >> kib) return kib * 1024;
  }
  return std::nullopt;
}

bool reset_peak() {
#ifdef __GLIBC__
  malloc_trim(0);  // what was freed before would otherwise be used again, unseen
#endif
  std::ofstream reset("/proc/self/clear_refs");
  return static_cast<bool>(reset << '5' << std::flush);
}

}  // namespace

std::optional<std::size_t> peak_memory_bytes(const std::function<void()>& call) {
  if (!reset_peak()) return std::nullopt;
  const std::optional<std::size_t> before = peak_resident_bytes();
  call();
  const std::optional<std::size_t> peak = peak_resident_bytes();
  if (!before || !peak) return std::nullopt;
  return *peak - *before;
}

}  // namespace consimd::bench
