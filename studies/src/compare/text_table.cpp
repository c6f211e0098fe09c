#include <consimd/studies/text_table.hpp>

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace consimd::studies {
namespace {

/// Characters, not bytes: those of UTF-8 but its continuation bytes.
std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

bool is_number(std::string_view cell) {
  return !cell.empty() && cell.find_first_not_of("0123456789.+-() e") == std::string_view::npos;
}

}  // namespace

std::string to_markdown(const TextTable& table) {
  const std::size_t columns = table.columns.size();
  std::vector<std::size_t> widths(columns, 3);
  std::vector<bool> right(columns, true);  // columns of numbers
  for (std::size_t c = 0; c < columns; ++c) {
    widths[c] = std::max(widths[c], width(table.columns[c]));
    for (const std::vector<std::string>& row : table.rows) {
      widths[c] = std::max(widths[c], width(row[c]));
      right[c] = right[c] && is_number(row[c]);
    }
  }
  std::string text = fmt::format("### {}\n\n", table.title);
  for (const std::string& paragraph : table.caption) text += paragraph + '\n';
  text += '\n';
  const auto add_row = [&](const std::vector<std::string>& row) {
    for (std::size_t c = 0; c < columns; ++c) {
      const std::string blanks(widths[c] - width(row[c]), ' ');
      text += right[c] ? fmt::format("| {}{} ", blanks, row[c]) : fmt::format("| {}{} ", row[c], blanks);
    }
    text += "|\n";
  };
  add_row(table.columns);
  for (std::size_t c = 0; c < columns; ++c) {
    const std::string dashes(widths[c], '-');
    text += right[c] ? fmt::format("|-{}:", dashes) : fmt::format("|-{}-", dashes);
  }
  text += "|\n";
  for (const std::vector<std::string>& row : table.rows) add_row(row);
  return text;
}

std::string to_csv(const TextTable& table) {
  std::string text = fmt::format("{}\n", fmt::join(table.columns, ","));
  for (const std::vector<std::string>& row : table.rows) text += fmt::format("{}\n", fmt::join(row, ","));
  return text;
}

}  // namespace consimd::studies
