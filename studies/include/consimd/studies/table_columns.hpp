// The columns of a study's tables: each is declared once, with its name, its member of a row and its meaning. Files,
// pages and Python take them from there.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <tuple>

namespace consimd::studies {

template <typename Member>
struct Column {
  std::string_view name;
  Member member;             ///< a pointer to a data member, or a function that makes a reference to one of a row
  std::string_view meaning;  ///< with its unit

  /// The value in a row, a reference.
  [[nodiscard]] constexpr decltype(auto) value(auto& row) const { return std::invoke(member, row); }
};

template <typename Member>
Column(std::string_view, Member, std::string_view) -> Column<Member>;

/// For the member of a column: `inner` of what a row has as `outer`.
[[nodiscard]] constexpr auto member_of(auto outer, auto inner) {
  return [=](auto& row) -> decltype(auto) { return (row.*outer.*inner); };
}

/// Calls `take` with every column, from left to right.
template <typename... Members, typename Take>
constexpr void for_each_column(const std::tuple<Column<Members>...>& columns, const Take& take) {
  std::apply([&](const auto&... column) { (take(column), ...); }, columns);
}

/// The first line of a table, without its newline: the names, separated by commas.
template <typename... Members>
[[nodiscard]] std::string csv_header(const std::tuple<Column<Members>...>& columns) {
  std::string line;
  for_each_column(columns, [&](const auto& column) {
    if (!line.empty()) line += ',';
    line += column.name;
  });
  return line;
}

}  // namespace consimd::studies
