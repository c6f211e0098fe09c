// Text files of numbers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace consimd::synth {

/// A table of numbers, row-major.
struct NumberTable {
  std::size_t columns = 0;
  std::vector<double> values;

  [[nodiscard]] std::size_t rows() const noexcept { return values.size() / columns; }
};

/// Reads lines of `columns` numbers, separated by blanks or single commas, whatever the locale. '#' starts a comment;
/// empty lines, CRLF ends and a UTF-8 byte-order mark are allowed. Throws std::runtime_error "FILE:LINE: what" on
/// anything else: another count of numbers, text, NaN or infinity.
[[nodiscard]] NumberTable read_number_table(const std::filesystem::path& path, std::size_t columns);

}  // namespace consimd::synth
