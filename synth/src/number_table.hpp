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
  /// The same of the last comment before the first row whose words name source and target x y z.
  std::vector<std::string> comment_names;
  std::vector<double> values;      ///< row after row
  std::vector<std::size_t> ends;   ///< where each row ends in `values`
  std::vector<std::size_t> lines;  ///< which line of the file each row is, from 1
  /// How many numbers each row would have if a comma between two digits were a decimal one, where it can be: where
  /// blanks separate them.
  std::vector<std::size_t> words;
  std::string decimal_comma;      ///< the first number with such a comma, as messages show it; empty: there is none
  std::size_t line_of_comma = 0;  ///< its line

  [[nodiscard]] std::size_t rows() const noexcept { return ends.size(); }
  [[nodiscard]] std::span<const double> row(std::size_t k) const {
    const std::size_t begin = k == 0 ? 0 : ends[k - 1];
    return std::span(values).subspan(begin, ends[k] - begin);
  }
};

/// How messages name a file.
[[nodiscard]] std::string shown_name(const std::filesystem::path& path);

/// Reads lines of numbers, separated by blanks or single commas or semicolons, whatever the locale. '#' starts a
/// comment, as do '//' and '%' at the beginning of a line; empty lines, ends of lines of all systems (LF, CRLF, CR), a
/// UTF-8 byte-order mark, double quotes around numbers, a spreadsheet's sep=; as the first line and a first line of
/// names are allowed. Throws std::runtime_error "FILE:LINE: what" on anything else: text, NaN or infinity, a decimal
/// comma; "FILE: what" where the whole file is at fault, as an empty one.
[[nodiscard]] NumberTable read_number_table(const std::filesystem::path& path);

/// Whether all rows have as many numbers.
[[nodiscard]] bool is_even(const NumberTable& table);

/// Of a table that is not as it should be: throws std::runtime_error "FILE:LINE: what" where all rows would have as
/// many numbers, `columns` or, of rows of unequal length, more, if their commas were decimal ones.
void require_no_decimal_commas(const NumberTable& table, std::size_t columns, const std::filesystem::path& path);

/// Throws std::runtime_error "FILE:LINE: what" unless each row has `columns` numbers. form: what the message ends with,
/// after the numbers.
void require_columns(const NumberTable& table, std::size_t columns, const std::filesystem::path& path,
                     const std::string& form = {});

}  // namespace consimd::synth
