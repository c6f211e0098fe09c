#include <consimd/kernels/isa.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

#include "dispatch.hpp"

namespace consimd {
namespace {

bool supported(Isa isa) {
  const auto isas = supported_isas();
  return std::find(isas.begin(), isas.end(), isa) != isas.end();
}

/// What `call` throws; fails if it throws nothing.
template <typename Call>
std::string refusal(Call call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  ADD_FAILURE() << "no std::invalid_argument";
  return {};
}

TEST(IsaNames, RoundTrip) {
  for (const Isa isa : known_isas()) EXPECT_EQ(parse_isa(to_string(isa)), isa);
}

TEST(IsaNames, UnknownOnesAreRefusedWithThoseThatAreKnown) {
  for (const char* bad : {"", "AVX2", "avx", "native"}) {
    const std::string message = refusal([&] { (void)parse_isa(bad); });
    EXPECT_NE(message.find('"' + std::string(bad) + '"'), std::string::npos) << message;
    for (const Isa isa : known_isas()) EXPECT_NE(message.find(to_string(isa)), std::string::npos) << message;
  }
}

TEST(KnownIsas, HoldThoseSupported) {
  for (const Isa isa : supported_isas()) {
    EXPECT_EQ(std::count(known_isas().begin(), known_isas().end(), isa), 1) << to_string(isa);
  }
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

TEST(ForcedIsa, IsTheOneNamedElseTheWidest) {
  EXPECT_EQ(detail::isa_or_widest(nullptr), supported_isas().back());
  EXPECT_EQ(detail::isa_or_widest(""), supported_isas().back());
  for (const Isa isa : known_isas()) {
    const std::string name(to_string(isa));
    if (supported(isa)) {
      EXPECT_EQ(detail::isa_or_widest(name.c_str()), isa);
    } else {
      const std::string message = refusal([&] { (void)detail::isa_or_widest(name.c_str()); });
      EXPECT_NE(message.find('"' + name + '"'), std::string::npos) << message;
      EXPECT_NE(message.find(to_string(supported_isas().back())), std::string::npos) << message;
    }
  }
  EXPECT_THROW((void)detail::isa_or_widest("unheard-of"), std::invalid_argument);
}

// Before any set_active_isa. CTest runs this once for each value of CONSIMD_ISA, in a process of its own.
TEST(FirstActiveIsa, IsTheOneOfTheEnvironment) {
  const char* forced = std::getenv("CONSIMD_ISA");
  if (forced == nullptr) {
    EXPECT_EQ(active_isa(), supported_isas().back());
  } else if (std::string_view(forced) == "scalar") {
    EXPECT_EQ(active_isa(), Isa::scalar);
  } else {
    EXPECT_THROW((void)active_isa(), std::invalid_argument);
  }
}

TEST(ActiveIsa, IsTheLastOneSet) {
  for (const Isa isa : known_isas()) {
    if (supported(isa)) {
      set_active_isa(isa);
      EXPECT_EQ(active_isa(), isa);
    } else {
      EXPECT_THROW(set_active_isa(isa), std::invalid_argument);
    }
  }
  set_active_isa(supported_isas().back());
}

TEST(KernelTables, AreFull) {
  // A table is function pointers and nothing else.
  using Entries = std::array<void (*)(), sizeof(detail::KernelTable) / sizeof(void (*)())>;
  for (const Isa isa : supported_isas()) {
    const auto entries = std::bit_cast<Entries>(detail::table_of(isa));
    EXPECT_EQ(std::count(entries.begin(), entries.end(), nullptr), 0) << to_string(isa);
  }
}

}  // namespace
}  // namespace consimd
