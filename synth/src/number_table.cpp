#include "number_table.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include <consimd/synth/text_file.hpp>

namespace consimd::synth {
namespace {

constexpr std::string_view kBlanks = " \t\v\f\r";

/// A word of the file as an error message may show it: short and printable.
std::string shown(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text(word.substr(0, kLongest));
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return word.size() > kLongest ? text + "..." : text;
}

/// Files of two bytes a character have a mark, or zeros in every other byte, which no text of numbers has.
void require_one_byte_characters(const std::filesystem::path& path, std::string_view text) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") ||
      text.substr(0, 64).find('\0') != std::string_view::npos) {
    throw std::runtime_error(path.string() +
                             ": is binary or UTF-16 text, expected UTF-8 or ASCII: convert it with 'iconv -f UTF-16 -t "
                             "UTF-8'");
  }
}

/// What a word that is no number most likely is, and what to do then.
std::string advice(std::string_view word, bool first_line) {
  if (word.find(';') != std::string_view::npos) return ": separate numbers by blanks or commas, not by ';'";
  const bool is_name = word.find_first_of("abcdfghijklmnopqrstuvwxyzABCDFGHIJKLMNOPQRSTUVWXYZ_\"'") == 0;
  if (first_line && is_name) return ": is this a header? Remove the line, or put '#' before it";
  return "";
}

/// One number without separators around it. Throws std::invalid_argument.
double parse(std::string_view word, bool first_line) {
  if (word.empty()) throw std::invalid_argument("nothing between two commas");
  const char* first = word.data() + (word.size() > 1 && word[0] == '+' && word[1] != '-' ? 1 : 0);
  const char* last = word.data() + word.size();
  double value = 0.0;
  const auto [rest, error] = std::from_chars(first, last, value);
  if (error == std::errc::result_out_of_range) {
    throw std::invalid_argument("'" + shown(word) + "' is out of a double's range");
  }
  if (error != std::errc() || rest != last) {
    throw std::invalid_argument("'" + shown(word) + "' is not a number" + advice(word, first_line));
  }
  if (!std::isfinite(value)) throw std::invalid_argument("'" + shown(word) + "' is not finite");
  return value;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Appends the numbers of a line that is not empty; returns how many. Throws std::invalid_argument.
std::size_t append_numbers(std::string_view line, bool first_line, std::vector<double>& values) {
  std::size_t count = 0;
  if (line.ends_with(',')) throw std::invalid_argument("a comma at the end of the line: remove it");
  for (;;) {
    const std::size_t end = line.find_first_of(" \t\v\f\r,");
    values.push_back(parse(line.substr(0, end), first_line));
    ++count;
    if (end == std::string_view::npos) return count;
    // Blanks around one comma belong to it.
    line = trimmed(line.substr(end));
    if (line.starts_with(',')) line = trimmed(line.substr(1));
  }
}

}  // namespace

NumberTable read_number_table(const std::filesystem::path& path, std::size_t columns) {
  const std::string text = read_text(path);
  require_one_byte_characters(path, text);
  const std::string name = path == "-" ? "standard input" : path.string();
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  NumberTable table{columns, {}};
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::size_t end = rest.find('\n');
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    try {
      const std::size_t count = append_numbers(line, table.values.empty(), table.values);
      if (count != columns)
        throw std::invalid_argument("expected " + std::to_string(columns) + " numbers, got " + std::to_string(count));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(name + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  return table;
}

}  // namespace consimd::synth
