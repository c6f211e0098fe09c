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

struct IsaName {
  Isa isa;
  std::string_view name;
};

/// Every instruction set there is a kernel for, in the order of the enumeration. Help, errors and tests take the names
/// from here.
constexpr std::array kNames{IsaName{Isa::scalar, "scalar"}, IsaName{Isa::sse2, "sse2"}, IsaName{Isa::avx2, "avx2"},
                            IsaName{Isa::avx512, "avx512"}, IsaName{Isa::neon, "neon"}};

constexpr std::size_t index(Isa isa) { return static_cast<std::size_t>(isa); }

constexpr auto kKnown = [] {
  std::array<Isa, kNames.size()> isas{};
  for (std::size_t k = 0; k < isas.size(); ++k) isas[k] = kNames[k].isa;
  return isas;
}();
static_assert([] {
  for (std::size_t k = 0; k < kKnown.size(); ++k) {
    if (index(kKnown[k]) != k) return false;
  }
  return true;
}());

bool always() noexcept { return true; }

// __builtin_cpu_supports asks the operating system too: a register file that it does not save counts as absent.
#ifdef CONSIMD_HAVE_AVX2
bool has_avx2() noexcept { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt"); }
#endif

#ifdef CONSIMD_HAVE_AVX512
bool has_avx512() noexcept {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("popcnt");
}

const detail::KernelTable& best_avx512_table() noexcept {
  static const detail::KernelTable table = [] {
    detail::KernelTable best = detail::avx512::table();
    if (__builtin_cpu_supports("avx512vpopcntdq")) detail::avx512::use_vector_popcount(best);
    return best;
  }();
  return table;
}
#endif

/// An instruction set that this build has kernels for.
struct BuiltIsa {
  Isa isa;
  bool (*runs_here)() noexcept;
  const detail::KernelTable& (*table)() noexcept;
};

/// Narrowest first.
constexpr BuiltIsa kBuilt[]{
    {Isa::scalar, always, detail::scalar::table},
#ifdef CONSIMD_HAVE_SSE2
    {Isa::sse2, always, detail::sse2::table},
#endif
#ifdef CONSIMD_HAVE_AVX2
    {Isa::avx2, has_avx2, detail::avx2::table},
#endif
#ifdef CONSIMD_HAVE_AVX512
    {Isa::avx512, has_avx512, best_avx512_table},
#endif
#ifdef CONSIMD_HAVE_NEON
    {Isa::neon, always, detail::neon::table},
#endif
};

std::vector<Isa> detect() {
  std::vector<Isa> isas;
  for (const BuiltIsa& built : kBuilt) {
    if (built.runs_here()) isas.push_back(built.isa);
  }
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

}  // namespace

std::string_view to_string(Isa isa) noexcept { return kNames[index(isa)].name; }

Isa parse_isa(std::string_view name) {
  for (const IsaName& known : kNames) {
    if (known.name == name) return known.isa;
  }
  throw std::invalid_argument("unknown instruction set \"" + std::string(name) + "\", expected one of " +
                              names_of(known_isas()));
}

std::span<const Isa> known_isas() noexcept { return kKnown; }

std::span<const Isa> supported_isas() noexcept {
  static const std::vector<Isa> isas = detect();
  return isas;
}

Isa active_isa() {
  int isa = chosen_isa.load(std::memory_order_relaxed);
  if (isa == kNotChosen) {
    const int initial = static_cast<int>(detail::isa_or_widest(std::getenv("CONSIMD_ISA")));
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

Isa isa_or_widest(const char* name) {
  if (name == nullptr || *name == '\0') return supported_isas().back();
  const Isa isa = parse_isa(name);
  require_supported(isa);
  return isa;
}

const KernelTable& table_of(Isa isa) noexcept {
  static const auto tables = [] {
    std::array<const KernelTable*, kKnown.size()> by_isa{};
    for (const BuiltIsa& built : kBuilt) {
      if (built.runs_here()) by_isa[index(built.isa)] = &built.table();
    }
    return by_isa;
  }();
  return *tables[index(isa)];
}

const KernelTable& active_table() { return table_of(active_isa()); }

}  // namespace detail
}  // namespace consimd
