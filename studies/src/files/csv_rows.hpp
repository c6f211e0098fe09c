// Rows of a study's tables as lines of text, and back.
#pragma once

#include <cstddef>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include <consimd/studies/table_columns.hpp>

#include "text/words.hpp"

namespace consimd::studies {

/// Takes the fields of a line from left to right. Throws std::invalid_argument that says what is wrong.
class CsvFields {
 public:
  explicit CsvFields(std::string_view line) : fields_(text::split(line, ',')) {}

  void take(std::string& value) { value = text(); }
  void take(bool& value) {
    const std::string_view field = text();
    if (field != "0" && field != "1") throw std::invalid_argument(fmt::format("expected 0 or 1, got '{}'", field));
    value = field == "1";
  }
  template <typename Number>
  void take(Number& value) {
    const std::string_view field = text();
    const auto number = text::number_in<Number>(field);
    if (!number) throw std::invalid_argument(fmt::format("bad value '{}'", field));
    value = *number;
  }

  void finish() const {
    if (taken_ < fields_.size()) throw std::invalid_argument("too many columns");
  }

 private:
  std::string_view text() {
    if (taken_ == fields_.size()) throw std::invalid_argument("too few columns");
    return fields_[taken_++];
  }

  std::vector<std::string_view> fields_;
  std::size_t taken_ = 0;
};

/// A line with its newline. Numbers read back to the same bits; a truth value is 1 or 0.
template <typename Columns, typename Row>
[[nodiscard]] std::string csv_row(const Columns& columns, const Row& row) {
  std::string line;
  for_each_column(columns, [&](const auto& column) {
    const auto& value = column.value(row);
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, bool>) {
      line += value ? "1," : "0,";
    } else {
      fmt::format_to(std::back_inserter(line), "{},", value);
    }
  });
  line.back() = '\n';
  return line;
}

/// Inverse of `csv_row`, the newline left out. Throws std::invalid_argument that says what is wrong.
template <typename Row, typename Columns>
[[nodiscard]] Row parse_csv_row(const Columns& columns, std::string_view line) {
  CsvFields fields(line);
  Row row;
  for_each_column(columns, [&](const auto& column) { fields.take(column.value(row)); });
  fields.finish();
  return row;
}

}  // namespace consimd::studies
