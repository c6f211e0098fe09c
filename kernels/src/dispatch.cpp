#include "dispatch.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace consimd {
namespace {

constexpr std::array<std::string_view, 5> kNames{"scalar", "sse2", "avx2", "avx512", "neon"};

// __builtin_cpu_supports asks the operating system too: a register file that it does not save counts as absent.
std::vector<Isa> detect() {
  std::vector<Isa> isas{Isa::scalar};
#ifdef CONSIMD_HAVE_SSE2
  isas.push_back(Isa::sse2);
#endif
#ifdef CONSIMD_HAVE_AVX2
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt")) {
    isas.push_back(Isa::avx2);
  }
#endif
#ifdef CONSIMD_HAVE_AVX512
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("popcnt")) {
    isas.push_back(Isa::avx512);
  }
#endif
#ifdef CONSIMD_HAVE_NEON
  isas.push_back(Isa::neon);
#endif
  return isas;
}

std::string names_of(std::span<const Isa> isas) {
  std::string names;
  for (const Isa isa : isas) names.append(names.empty() ? "" : ", ").append(to_string(isa));
  return names;
}

void require_supported(Isa isa) {
  const auto supported = supported_isas();
  if (std::find(supported.begin(), supported.end(), isa) != supported.end()) return;
  throw std::invalid_argument("instruction set \"" + std::string(to_string(isa)) +
                              "\" is not supported here; supported: " + names_of(supported));
}

constexpr int kNotChosen = -1;
std::atomic<int> chosen_isa{kNotChosen};

Isa initial_isa() {
  const char* forced = std::getenv("CONSIMD_ISA");
  if (forced == nullptr || *forced == '\0') return supported_isas().back();
  const Isa isa = parse_isa(forced);
  require_supported(isa);
  return isa;
}

}  // namespace

std::string_view to_string(Isa isa) noexcept { return kNames[static_cast<std::size_t>(isa)]; }

Isa parse_isa(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found != kNames.end()) return static_cast<Isa>(found - kNames.begin());
  throw std::invalid_argument("unknown instruction set \"" + std::string(name) +
                              "\", expected one of scalar, sse2, avx2, avx512, neon");
}

std::span<const Isa> supported_isas() noexcept {
  static const std::vector<Isa> isas = detect();
  return isas;
}

Isa active_isa() {
  int isa = chosen_isa.load(std::memory_order_relaxed);
  if (isa == kNotChosen) {
    const int initial = static_cast<int>(initial_isa());
    // A concurrent set_active_isa wins over the initial choice.
    if (chosen_isa.compare_exchange_strong(isa, initial, std::memory_order_relaxed)) isa = initial;
  }
  return static_cast<Isa>(isa);
}

void set_active_isa(Isa isa) {
  require_supported(isa);
  chosen_isa.store(static_cast<int>(isa), std::memory_order_relaxed);
}

namespace detail {

const KernelTable& table_of(Isa isa) noexcept {
  switch (isa) {
#ifdef CONSIMD_HAVE_SSE2
    case Isa::sse2:
      return sse2::table();
#endif
#ifdef CONSIMD_HAVE_AVX2
    case Isa::avx2:
      return avx2::table();
#endif
#ifdef CONSIMD_HAVE_AVX512
    case Isa::avx512: {
      static const KernelTable table = [] {
        KernelTable best = avx512::table();
        if (__builtin_cpu_supports("avx512vpopcntdq")) avx512::use_vector_popcount(best);
        return best;
      }();
      return table;
    }
#endif
#ifdef CONSIMD_HAVE_NEON
    case Isa::neon:
      return neon::table();
#endif
    default:
      return scalar::table();
  }
}

const KernelTable& active_table() { return table_of(active_isa()); }

}  // namespace detail
}  // namespace consimd
