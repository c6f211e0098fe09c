#include "correspondence_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "named_columns.hpp"
#include "number_table.hpp"

namespace consimd::synth {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error(shown_name(path) + ": " + what);
}

/// Whether the first number of each row counts the rows, from 0 or 1.
bool counts_rows(const NumberTable& table) {
  const double first = table.row(0)[0];
  if (first != 0.0 && first != 1.0) return false;
  for (std::size_t k = 0; k < table.rows(); ++k) {
    if (table.row(k)[0] != first + static_cast<double>(k)) return false;
  }
  return true;
}

/// Whether it does so in so many rows that it is no chance.
bool has_index(const NumberTable& table) {
  constexpr std::size_t kFewest = 8;
  return table.rows() >= kFewest && counts_rows(table);
}

/// Whether commas that are decimal ones may have made two numbers of each.
bool may_be_halves(const NumberTable& table) {
  return table.row(0).size() == 12 &&
         std::ranges::all_of(table.values, [](double value) { return value == std::floor(value); });
}

/// Throws what is missing in a table whose rows are no correspondences as they are, or how to choose its columns.
[[noreturn]] void refuse_columns(const NumberTable& table, const fs::path& path) {
  require_no_decimal_commas(table, 6, path);
  const std::size_t width = table.row(0).size();
  if (!is_even(table)) require_columns(table, std::max<std::size_t>(width, 6), path);
  if (width < 6) {
    const bool is_point = width == 3;
    require_columns(table, 6, path,
                    std::string(": a correspondence is a line of source x y z and target x y z") +
                        (is_point ? "; two files of points, row by row, are given as SOURCE TARGET --pairs rows" : ""));
  }
  fail(path, std::to_string(width) + " numbers a line, expected 6: " +
                 (may_be_halves(table) ? "write points where commas are decimal ones, else " : "") +
                 "say which of them are source x y z and target x y z, counted from 1, as in --columns 2,3,4,5,6,7");
}

[[noreturn]] void refuse_names(const NumberTable& table, const fs::path& path) {
  std::string names;
  for (const std::string& name : table.names) names.append(names.empty() ? "" : ", ").append(name);
  fail(path,
       "columns named " + names +
           ", which do not tell source x y z and target x y z: say which they are, counted from 1, as in --columns "
           "2,3,4,5,6,7");
}

/// What names tell of the columns. Rows may have a number more: before the others one that counts the rows, as R and
/// pandas write them, or behind them.
NamedColumns told_by(const std::vector<std::string>& names, const NumberTable& table) {
  const std::size_t width = table.row(0).size();
  if (names.size() != width && names.size() + 1 != width) return {};
  NamedColumns named = columns_by_name(names);
  if (names.size() == width || !counts_rows(table)) return named;
  for (std::size_t& column : named.columns) ++column;
  return named;
}

/// Whether the first row numbers the columns, as pandas does for an array without names: other rows have fractions.
bool numbers_columns(const NumberTable& table) {
  const std::span<const double> first = table.row(0);
  for (std::size_t c = 0; c < first.size(); ++c) {
    if (first[c] != static_cast<double>(c)) return false;
  }
  return first.size() >= 6 &&
         std::ranges::any_of(table.values, [](double value) { return value != std::floor(value); });
}

/// The table without its first row.
NumberTable without_first(NumberTable table) {
  const std::size_t width = table.ends.front();
  table.values.erase(table.values.begin(), table.values.begin() + static_cast<std::ptrdiff_t>(width));
  table.ends.erase(table.ends.begin());
  for (std::size_t& end : table.ends) end -= width;
  table.lines.erase(table.lines.begin());
  table.words.erase(table.words.begin());
  return table;
}

/// The columns that the file tells.
std::array<std::size_t, 6> columns_of(const NumberTable& table, const fs::path& path) {
  if (is_even(table)) {
    const std::size_t width = table.row(0).size();
    const NamedColumns named = told_by(table.names, table);
    if (named.kind == NamedColumns::Kind::found) return named.columns;
    if (named.kind == NamedColumns::Kind::unclear) refuse_names(table, path);
    if (!table.names.empty() && table.names.size() != width && table.names.size() + 1 != width) {
      fail(path, std::to_string(table.names.size()) + " names, but " + std::to_string(width) + " numbers a line");
    }
    const NamedColumns commented = told_by(table.comment_names, table);
    if (commented.kind == NamedColumns::Kind::found) return commented.columns;
    if (width == 6) return {0, 1, 2, 3, 4, 5};
    if (width == 7 && has_index(table)) return {1, 2, 3, 4, 5, 6};
  }
  refuse_columns(table, path);
}

/// Those that were chosen, counted from 1.
std::array<std::size_t, 6> chosen_columns(const NumberTable& table, std::span<const std::size_t> chosen,
                                          const fs::path& path) {
  const std::size_t width = table.row(0).size();
  if (!is_even(table)) require_no_decimal_commas(table, 6, path);
  require_columns(table, width, path);
  std::array<std::size_t, 6> columns{};
  for (std::size_t c = 0; c < 6; ++c) {
    if (chosen[c] > width) {
      fail(path, "column " + std::to_string(chosen[c]) + " of " + std::to_string(width) + " in --columns");
    }
    columns[c] = chosen[c] - 1;
  }
  return columns;
}

}  // namespace

CorrespondenceRows read_correspondence_rows(const fs::path& path, std::span<const std::size_t> chosen) {
  NumberTable table = read_number_table(path);
  const auto require_three = [&] {
    if (table.rows() >= 3) return;
    fail(path, "expected at least 3 correspondences, got " + std::to_string(table.rows()) + ": a pose needs three");
  };
  if (table.rows() == 0) require_three();
  if (table.names.empty() && numbers_columns(table)) table = without_first(std::move(table));
  const std::array<std::size_t, 6> columns =
      chosen.empty() ? columns_of(table, path) : chosen_columns(table, chosen, path);
  require_three();
  if (table.row(0).size() == 6 && std::ranges::is_sorted(columns)) return {std::move(table.values)};
  CorrespondenceRows rows;
  rows.values.reserve(6 * table.rows());
  for (std::size_t k = 0; k < table.rows(); ++k) {
    for (const std::size_t c : columns) rows.values.push_back(table.row(k)[c]);
  }
  return rows;
}

}  // namespace consimd::synth
