// Text files of numbers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace consimd::synth {

/// Lines of numbers, as many in each as there are.
struct NumberTable {
  std::vector<std::string> names;  ///< of the columns, where the first line has names in place of numbers
  std::vector<double> values;      ///< row after row
  std::vector<std::size_t> ends;   ///< where each row ends in `values`
  std::vector<std::size_t> lines;  ///< which line of the file each row is, from 1

  [[nodiscard]] std::size_t rows() const noexcept { return ends.size(); }
  [[nodiscard]] std::span<const double> row(std::size_t k) const {
    const std::size_t begin = k == 0 ? 0 : ends[k - 1];
    return std::span(values).subspan(begin, ends[k] - begin);
  }
};

/// Reads lines of numbers, separated by blanks or single commas or semicolons, whatever the locale. '#' starts a
/// comment; empty lines, CRLF ends, a UTF-8 byte-order mark and a first line of names are allowed. Throws
/// std::runtime_error "FILE:LINE: what" on anything else: text, NaN or infinity, a decimal comma.
[[nodiscard]] NumberTable read_number_table(const std::filesystem::path& path);

/// Throws std::runtime_error "FILE:LINE: what" unless each row has `columns` numbers.
void require_columns(const NumberTable& table, std::size_t columns, const std::filesystem::path& path);

}  // namespace consimd::synth
