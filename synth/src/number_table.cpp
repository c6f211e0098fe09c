#include "number_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <consimd/synth/text_file.hpp>

#include "named_columns.hpp"
#include "text/words.hpp"

namespace consimd::synth {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, std::size_t line, const std::string& what) {
  throw std::runtime_error(shown_name(path) + ":" + std::to_string(line) + ": " + what);
}

/// Files of two bytes a character have a mark, or zeros in every other byte, which no text of numbers has.
void require_one_byte_characters(const std::filesystem::path& path, std::string_view text) {
  if (text.starts_with("\x1F\x8B")) {
    throw std::runtime_error(shown_name(path) + ": is compressed by gzip, expected text: unpack it with 'gunzip'");
  }
  if (text.starts_with("\x93NUMPY") || text.starts_with("PK\3\4")) {
    throw std::runtime_error(shown_name(path) +
                             ": is of NumPy or a zip archive, expected text: name a file of arrays *.npy or *.npz");
  }
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") ||
      text.substr(0, 64).find('\0') != std::string_view::npos) {
    throw std::runtime_error(shown_name(path) +
                             ": is binary or UTF-16 text, expected UTF-8 or ASCII: convert it with 'iconv -f UTF-16 -t "
                             "UTF-8'");
  }
}

/// A word of a line, without its quotes.
struct Word {
  std::string_view text;
  bool quoted = false;
};

/// Whether a word is a number but for the comma in the place of its point.
bool has_decimal_comma(std::string_view word) {
  constexpr std::string_view kDigits = "0123456789";
  const std::size_t comma = word.find(',');
  if (comma == std::string_view::npos || comma == 0 || comma + 1 == word.size()) return false;
  if (word.find(',', comma + 1) != std::string_view::npos) return false;
  if (kDigits.find(word[comma - 1]) == std::string_view::npos) return false;
  if (kDigits.find(word[comma + 1]) == std::string_view::npos) return false;
  std::string plain(word.substr(word[0] == '+' ? 1 : 0));
  plain[plain.find(',')] = '.';
  return text::number_in<double>(plain).has_value();
}

/// What to do with a word that is not a number, where that shows.
std::string remedy(Word word, char separator) {
  if (has_decimal_comma(word.text)) {
    return separator == ';' ? std::string(": ") + text::kDecimalPoints : ": write a decimal point, not a comma";
  }
  const bool holds_several = word.quoted && word.text.find_first_of(" \t,;") != std::string_view::npos;
  if (holds_several || word.text.find_first_of("\"'") != std::string_view::npos) return ": remove the quotes";
  if (word.text.find(',') != std::string_view::npos) return ": write a decimal point, and nothing between thousands";
  return {};
}

/// One number, the one of this column, counted from 1. Throws std::invalid_argument.
double parse(Word word, char separator, std::size_t column) {
  if (word.text.empty()) {
    const std::string name = separator == ';' ? "semicolon" : "comma";
    const std::string place = word.quoted   ? "between quotes"
                              : column == 1 ? "before the first " + name
                                            : "between two " + name + "s";
    throw std::invalid_argument(
        "column " + std::to_string(column) + " is empty, " + place + ": fill it in or remove the line" +
        (word.quoted || column == 1 ? "" : "; where two " + name + "s stand for one, write one"));
  }
  const std::string_view text = word.text;
  const char* first = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0);
  const char* last = text.data() + text.size();
  double value = 0.0;
  const auto [rest, error] = std::from_chars(first, last, value);
  if (error == std::errc::result_out_of_range) {
    throw std::invalid_argument("'" + text::shown(text) + "' is out of a double's range");
  }
  if (error != std::errc() || rest != last) {
    throw std::invalid_argument("'" + text::shown(text) + "' is not a number" + remedy(word, separator));
  }
  if (!std::isfinite(value)) throw std::invalid_argument("'" + text::shown(text) + "' is not finite");
  return value;
}

/// How many characters come before the first that `ends`. Of many characters much faster than find_first_of.
template <typename Ends>
std::size_t length_until(std::string_view text, const Ends& ends) {
  return static_cast<std::size_t>(std::ranges::find_if(text, ends) - text.begin());
}

/// Takes the first line off a text: up to a line feed, or a carriage return alone, as old Macs wrote them. Carriage
/// returns before a line feed are of its line.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = length_until(rest, [](char c) { return c == '\n' || c == '\r'; });
  const std::size_t feed = std::min(rest.find_first_not_of('\r', end), rest.size());
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(feed < rest.size() && rest[feed] == '\n' ? feed + 1 : std::min(end + 1, rest.size()));
  return line;
}

/// How many characters of a line are a word in quotes and these, where it begins with one; else 0.
std::size_t quoted_length(std::string_view line, std::string_view ends) {
  const std::size_t quoted = text::quoted_length(line);
  if (quoted == 0 || quoted == line.size()) return quoted;
  return ends.find(line[quoted]) != std::string_view::npos ? quoted : 0;
}

/// Calls use(word) for the words of a line that is not empty: between blanks and separators. Blanks around a separator
/// belong to it.
template <typename Use>
void for_each_word(std::string_view line, char separator, const Use& use) {
  if (line.ends_with(separator)) {
    throw std::invalid_argument(std::string("a ") + (separator == ';' ? "semicolon" : "comma") +
                                " at the end of the line: remove it");
  }
  const std::string ends = std::string(text::kBlanks) + separator;
  for (;;) {
    const std::size_t quoted = quoted_length(line, ends);
    const std::size_t end = quoted > 0 ? quoted : std::min(line.find_first_of(ends), line.size());
    use(quoted > 0 ? Word{line.substr(1, quoted - 2), true} : Word{line.substr(0, end)});
    if (end == line.size()) return;
    line = text::trimmed(line.substr(end));
    if (line.starts_with(separator)) line = text::trimmed(line.substr(1));
  }
}

/// The words between blanks of a line whose commas may be decimal ones.
struct DecimalCommas {
  std::size_t words = 0;   ///< 0: they cannot be, or there are none
  std::string_view first;  ///< with such a comma
};

DecimalCommas decimal_commas_of(std::string_view line) {
  if (line.find(',') == std::string_view::npos) return {};
  DecimalCommas found;
  for (; !line.empty(); ++found.words) {
    const std::string_view word = line.substr(0, length_until(line, text::is_blank));
    const bool decimal = has_decimal_comma(word);
    if (!decimal && word.find_first_of(",;\"") != std::string_view::npos) return {};
    if (decimal && found.first.empty()) found.first = word;
    line = text::trimmed(line.substr(word.size()));
  }
  return found;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// Whether a word begins as a name does, or, in quotes, has a letter at all, and is no number for all that, as nan is.
bool is_name(Word word) {
  if (word.quoted ? std::ranges::none_of(word.text, is_letter) : word.text.empty() || !is_letter(word.text.front())) {
    return false;
  }
  double value = 0.0;
  const char* const end = word.text.data() + word.text.size();
  const auto [rest, error] = std::from_chars(word.text.data(), end, value);
  return error == std::errc::invalid_argument || rest != end;
}

/// Calls use(word) for the words of a line of names, which hold blanks where something else separates them.
template <typename Use>
void for_each_name(std::string_view line, const Use& use) {
  const char separator = text::separator_of(line, true);
  if (separator == ' ') {
    for_each_word(line, separator, use);
    return;
  }
  if (separator != '\t' && line.ends_with(separator)) {
    throw std::invalid_argument(std::string("a ") + (separator == ';' ? "semicolon" : "comma") +
                                " at the end of the line: remove it");
  }
  for (bool more = true; more;) {
    line = text::trimmed(line);
    const std::size_t quoted = quoted_length(line, std::string(text::kBlanks) + separator);
    const std::size_t end = std::min(line.find(separator, quoted), line.size());
    use(quoted > 0 ? Word{line.substr(1, quoted - 2), true} : Word{text::trimmed(line.substr(0, end))});
    more = end < line.size();
    line.remove_prefix(more ? end + 1 : end);
  }
}

/// The words of a line that names its columns, of which some may be left empty, as that of an index is; none where
/// another is none.
std::vector<std::string> names_of(std::string_view line) {
  std::vector<std::string> names;
  bool all = true;
  bool some = false;
  for_each_name(line, [&](Word word) {
    // The unit of the name before it.
    if (!names.empty() && !word.quoted && (word.text.starts_with('[') || word.text.starts_with('('))) return;
    all = all && (word.text.empty() || is_name(word));
    some = some || !word.text.empty();
    names.emplace_back(word.text);
  });
  return all && some ? names : std::vector<std::string>();
}

/// The same of a comment, which may be anything.
std::vector<std::string> names_in_comment(std::string_view comment) {
  try {
    return names_of(text::trimmed(comment));
  } catch (const std::invalid_argument&) {
    return {};
  }
}

}  // namespace

std::string shown_name(const std::filesystem::path& path) { return path == "-" ? "standard input" : path.string(); }

NumberTable read_number_table(const std::filesystem::path& path) {
  const std::string text = read_text(path);
  if (text.empty()) throw std::runtime_error(shown_name(path) + ": is empty, expected lines of numbers");
  require_one_byte_characters(path, text);
  std::string_view rest = text::without_mark(text);
  NumberTable table;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    std::string_view line = text::trimmed(take_line(rest));
    if (const auto comment = text::comment_of(line)) {
      if (table.rows() > 0) continue;
      std::vector<std::string> names = names_in_comment(*comment);
      if (columns_by_name(names).kind == NamedColumns::Kind::found) table.comment_names = std::move(names);
      continue;
    }
    line = text::trimmed(text::without_comment(line));
    if (line.empty() || (number == 1 && line.starts_with("sep="))) continue;
    const std::size_t begin = table.values.size();
    try {
      if (table.rows() == 0 && table.names.empty()) {
        table.names = names_of(line);
        if (!table.names.empty()) continue;
      }
      const char separator = text::separator_of(line, false);
      for_each_word(line, separator, [&](Word word) {
        table.values.push_back(parse(word, separator, table.values.size() - begin + 1));
      });
    } catch (const std::invalid_argument& error) {
      fail(path, number, error.what());
    }
    table.ends.push_back(table.values.size());
    table.lines.push_back(number);
    const DecimalCommas commas = decimal_commas_of(line);
    table.words.push_back(commas.words > 0 ? commas.words : table.values.size() - begin);
    if (commas.words > 0 && table.decimal_comma.empty()) {
      table.decimal_comma = text::shown(commas.first);
      table.line_of_comma = number;
    }
  }
  return table;
}

bool is_even(const NumberTable& table) {
  for (std::size_t k = 1; k < table.rows(); ++k) {
    if (table.row(k).size() != table.row(0).size()) return false;
  }
  return true;
}

void require_no_decimal_commas(const NumberTable& table, std::size_t columns, const std::filesystem::path& path) {
  if (table.decimal_comma.empty()) return;
  const std::size_t words = table.words.front();
  const bool explains = words == columns || (words > columns && !is_even(table));
  if (!explains || std::ranges::any_of(table.words, [&](std::size_t count) { return count != words; })) return;
  fail(path, table.line_of_comma, "'" + table.decimal_comma + "' has a decimal comma: " + text::kDecimalPoints);
}

void require_columns(const NumberTable& table, std::size_t columns, const std::filesystem::path& path,
                     const std::string& form) {
  for (std::size_t k = 0; k < table.rows(); ++k) {
    const std::size_t count = table.row(k).size();
    if (count == columns) continue;
    fail(path, table.lines[k], "expected " + std::to_string(columns) + " numbers, got " + std::to_string(count) + form);
  }
}

}  // namespace consimd::synth
