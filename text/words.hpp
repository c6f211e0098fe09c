// Lines, words, numbers and comments of text, for all that reads files and arguments. Not installed.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace consimd::text {

/// What separates words within a line.
inline constexpr std::string_view kBlanks = " \t\v\f\r";

[[nodiscard]] inline bool is_blank(char c) noexcept {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\r';  // find() takes seven times as long
}

/// Without the blanks around it.
[[nodiscard]] inline std::string_view trimmed(std::string_view text) noexcept {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Without the byte order mark that UTF-8 may begin with.
[[nodiscard]] inline std::string_view without_mark(std::string_view text) noexcept {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

/// Takes the first line off a text, without the line feed that ends it.
[[nodiscard]] inline std::string_view take_line(std::string_view& rest) noexcept {
  const std::string_view line = rest.substr(0, rest.find('\n'));
  rest.remove_prefix(std::min(rest.size(), line.size() + 1));
  return line;
}

/// The parts between separators, a character or any of a string's: one more than there are of these, some perhaps
/// empty.
template <typename Separators>
[[nodiscard]] std::vector<std::string_view> split(std::string_view text, const Separators& separators) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find_first_of(separators);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

/// What separates the words of a line: a semicolon or comma where it has any, else a tab where `tabs` says so, else
/// blanks.
[[nodiscard]] inline char separator_of(std::string_view line, bool tabs) noexcept {
  for (const char separator : {';', ','}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  return tabs && line.find('\t') != std::string_view::npos ? '\t' : ' ';
}

/// The length of a word in quotes at the beginning of a line, these included; 0 where it begins with none.
[[nodiscard]] inline std::size_t quoted_length(std::string_view line) noexcept {
  const std::size_t closing = line.starts_with('"') ? line.find('"', 1) : std::string_view::npos;
  return closing == std::string_view::npos ? 0 : closing + 1;
}

/// The number that the whole text is, within the range of its type.
template <typename Number>
[[nodiscard]] std::optional<Number> number_in(std::string_view text) noexcept {
  Number value{};
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || rest != text.data() + text.size()) return std::nullopt;
  return value;
}

/// In small letters of ASCII.
[[nodiscard]] inline std::string lower(std::string_view word) {
  std::string small(word);
  std::ranges::transform(small, small.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return small;
}

/// A word of a file as an error message may show it: short and printable.
[[nodiscard]] inline std::string shown(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string printable(word.substr(0, kLongest));
  std::ranges::replace_if(
      printable, [](char c) { return c < ' ' || c > '~'; }, '?');
  return word.size() > kLongest ? printable + "..." : printable;
}

/// What a line that begins as comments do, with '#', '//' or '%', has after that.
[[nodiscard]] inline std::optional<std::string_view> comment_of(std::string_view line) noexcept {
  line = trimmed(line);
  for (const std::string_view mark : {"#", "//", "%"}) {
    if (line.starts_with(mark)) return line.substr(mark.size());
  }
  return std::nullopt;
}

/// Nothing of a comment; of another line what comes before a '#' that no word holds, as 1.#INF does.
[[nodiscard]] inline std::string_view without_comment(std::string_view line) noexcept {
  if (comment_of(line)) return {};
  for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1)) {
    if (is_blank(line[at - 1]) || line[at - 1] == ',' || line[at - 1] == ';') return line.substr(0, at);
  }
  return line;
}

/// What to do with a file whose commas are all decimal ones.
inline constexpr const char* kDecimalPoints = "write decimal points, as 'tr , . < FILE' does";

}  // namespace consimd::text
