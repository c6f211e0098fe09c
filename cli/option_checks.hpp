// Checks of option values that fail in one clear line.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "text/words.hpp"

namespace consimd::cli {

/// Digits only, from `least` to `most`: CLI11 alone takes -1 for the largest unsigned number.
[[nodiscard]] inline CLI::Validator whole_number(std::uint64_t least = 0,
                                                 std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) {
  return CLI::Validator(
      [least, most](const std::string& text) -> std::string {
        const auto value = text::number_in<std::uint64_t>(text);
        if (value && *value >= least && *value <= most) return {};
        return fmt::format("expected a whole number from {} to {}, got '{}'", least, most, text);
      },
      {});
}

}  // namespace consimd::cli
