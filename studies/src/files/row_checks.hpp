// Checks of what the row of a table says: files may be damaged, or written by others.
#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include <consimd/solvers/registration.hpp>

#include <consimd/studies/outside_solver.hpp>

namespace consimd::studies {

/// Throws std::invalid_argument that names column and value unless `holds`.
template <typename Value>
void require_column(bool holds, std::string_view column, const Value& value) {
  if (!holds) throw std::invalid_argument(fmt::format("bad {} '{}'", column, value));
}

/// A length, an angle or a time.
[[nodiscard]] inline bool is_size(double value) { return std::isfinite(value) && value >= 0.0; }

[[nodiscard]] inline bool is_share(double value) { return value >= 0.0 && value <= 1.0; }

/// Whether a solver reports that status, or an outside program gets it.
[[nodiscard]] inline bool is_status(std::string_view name) {
  if (is_failure(name)) return true;
  for (std::uint8_t number = 0;; ++number) {
    const std::string_view status = to_string(static_cast<Status>(number));
    if (status == "unknown") return false;  // the list has ended
    if (status == name) return true;
  }
}

}  // namespace consimd::studies
