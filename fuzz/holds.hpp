// What must hold for every input.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace consimd::fuzz {

/// Ends the process, which libFuzzer takes for a finding, unless `condition` is true.
inline void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

/// Calls what reads foreign data: it may refuse them by the exceptions that its contract names, by no other.
template <typename Read>
void may_refuse(const Read& read) {
  try {
    read();
  } catch (const std::invalid_argument&) {
  } catch (const std::runtime_error&) {
  }
}

}  // namespace consimd::fuzz
