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

[[noreturn]] void fail(const std::filesystem::path& path, std::size_t line, const std::string& what) {
  const std::string name = path == "-" ? "standard input" : path.string();
  throw std::runtime_error(name + ":" + std::to_string(line) + ": " + what);
}

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

/// One number without separators around it. Throws std::invalid_argument.
double parse(std::string_view word, bool semicolons) {
  if (word.empty()) {
    throw std::invalid_argument(std::string("nothing between two ") + (semicolons ? "semicolons" : "commas"));
  }
  const char* first = word.data() + (word.size() > 1 && word[0] == '+' && word[1] != '-' ? 1 : 0);
  const char* last = word.data() + word.size();
  double value = 0.0;
  const auto [rest, error] = std::from_chars(first, last, value);
  if (error == std::errc::result_out_of_range) {
    throw std::invalid_argument("'" + shown(word) + "' is out of a double's range");
  }
  if (error != std::errc() || rest != last) {
    throw std::invalid_argument("'" + shown(word) + "' is not a number" +
                                (word.find(',') == std::string_view::npos ? "" : ": write a point, not a comma"));
  }
  if (!std::isfinite(value)) throw std::invalid_argument("'" + shown(word) + "' is not finite");
  return value;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Calls use(word) for the words of a line that is not empty: between blanks, and semicolons where the line has any,
/// else commas. Blanks around one of these belong to it.
template <typename Use>
void for_each_word(std::string_view line, const Use& use) {
  const char separator = line.find(';') == std::string_view::npos ? ',' : ';';
  if (line.ends_with(separator)) {
    throw std::invalid_argument(std::string("a ") + (separator == ';' ? "semicolon" : "comma") +
                                " at the end of the line: remove it");
  }
  const std::string ends = std::string(kBlanks) + separator;
  for (;;) {
    const std::size_t end = line.find_first_of(ends);
    use(line.substr(0, end), separator == ';');
    if (end == std::string_view::npos) return;
    line = trimmed(line.substr(end));
    if (line.starts_with(separator)) line = trimmed(line.substr(1));
  }
}

/// The words of a line that names its columns; none where one of them does not begin as a name does, or is a number.
std::vector<std::string> names_of(std::string_view line) {
  std::vector<std::string> names;
  bool all = true;
  for_each_word(line, [&](std::string_view word, bool) {
    double value = 0.0;
    const char first = word.empty() ? '0' : word.front();
    const bool begins =
        (first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z') || first == '_' || first == '"';
    all = all && begins && std::from_chars(word.data(), word.data() + word.size(), value).ec != std::errc();
    names.emplace_back(word);
  });
  return all ? names : std::vector<std::string>();
}

}  // namespace

NumberTable read_number_table(const std::filesystem::path& path) {
  const std::string text = read_text(path);
  require_one_byte_characters(path, text);
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  NumberTable table;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::size_t end = rest.find('\n');
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    try {
      if (table.rows() == 0 && table.names.empty()) {
        table.names = names_of(line);
        if (!table.names.empty()) continue;
      }
      for_each_word(line,
                    [&](std::string_view word, bool semicolons) { table.values.push_back(parse(word, semicolons)); });
    } catch (const std::invalid_argument& error) {
      fail(path, number, error.what());
    }
    table.ends.push_back(table.values.size());
    table.lines.push_back(number);
  }
  return table;
}

void require_columns(const NumberTable& table, std::size_t columns, const std::filesystem::path& path) {
  for (std::size_t k = 0; k < table.rows(); ++k) {
    const std::size_t count = table.row(k).size();
    if (count == columns) continue;
    fail(path, table.lines[k], "expected " + std::to_string(columns) + " numbers, got " + std::to_string(count));
  }
}

}  // namespace consimd::synth
