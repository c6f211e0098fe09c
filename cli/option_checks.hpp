// Checks of option values that fail in one clear line.
#pragma once

#include <charconv>
#include <cstdint>
#include <limits>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace consimd::cli {

/// Digits only, from `least` to `most`: CLI11 alone takes -1 for the largest unsigned number.
[[nodiscard]] inline CLI::Validator whole_number(std::uint64_t least = 0,
                                                 std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) {
  return CLI::Validator(
      [least, most](const std::string& text) -> std::string {
        std::uint64_t value = 0;
        const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error == std::errc() && rest == text.data() + text.size() && value >= least && value <= most) return {};
        return fmt::format("expected a whole number from {} to {}, got '{}'", least, most, text);
      },
      {});
}

}  // namespace consimd::cli
