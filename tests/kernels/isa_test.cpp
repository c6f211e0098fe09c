#include <consimd/kernels/isa.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

namespace consimd {
namespace {

constexpr Isa kAll[] = {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512, Isa::neon};

bool supported(Isa isa) {
  const auto isas = supported_isas();
  return std::find(isas.begin(), isas.end(), isa) != isas.end();
}

bool is_supported_name(std::string_view name) {
  return std::any_of(std::begin(kAll), std::end(kAll),
                     [&](Isa isa) { return to_string(isa) == name && supported(isa); });
}

TEST(IsaNames, RoundTrip) {
  for (const Isa isa : kAll) EXPECT_EQ(parse_isa(to_string(isa)), isa);
  for (const char* bad : {"", "AVX2", "avx", "native"}) EXPECT_THROW((void)parse_isa(bad), std::invalid_argument);
}

TEST(SupportedIsas, StartWithScalarAndEndWithTheWidest) {
  ASSERT_FALSE(supported_isas().empty());
  EXPECT_EQ(supported_isas().front(), Isa::scalar);
  EXPECT_TRUE(std::is_sorted(supported_isas().begin(), supported_isas().end()));
#if defined(__x86_64__)
  EXPECT_TRUE(supported(Isa::sse2));
  EXPECT_FALSE(supported(Isa::neon));
#elif defined(__aarch64__)
  EXPECT_TRUE(supported(Isa::neon));
#endif
}

// Before any set_active_isa. CTest runs this once for each value of CONSIMD_ISA, in a process of its own.
TEST(FirstActiveIsa, IsTheOneForcedElseTheWidest) {
  const char* forced = std::getenv("CONSIMD_ISA");
  if (forced == nullptr || *forced == '\0') {
    EXPECT_EQ(active_isa(), supported_isas().back());
  } else if (is_supported_name(forced)) {
    EXPECT_EQ(to_string(active_isa()), forced);
  } else {
    EXPECT_THROW((void)active_isa(), std::invalid_argument);
  }
}

TEST(ActiveIsa, IsTheLastOneSet) {
  for (const Isa isa : kAll) {
    if (supported(isa)) {
      set_active_isa(isa);
      EXPECT_EQ(active_isa(), isa);
    } else {
      EXPECT_THROW(set_active_isa(isa), std::invalid_argument);
    }
  }
  set_active_isa(supported_isas().back());
}

}  // namespace
}  // namespace consimd
