#include "files/records.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

namespace consimd::features::detail {
namespace {

template <typename T>
double number(const char* at, bool swapped) {
  std::array<char, sizeof(T)> bytes;
  std::copy_n(at, sizeof(T), bytes.begin());
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  T value;
  std::memcpy(&value, bytes.data(), sizeof(T));
  return static_cast<double>(value);
}

double number(const char* at, NumberType type, bool swapped) {
  switch (type) {
    case NumberType::int8:
      return number<std::int8_t>(at, swapped);
    case NumberType::uint8:
      return number<std::uint8_t>(at, swapped);
    case NumberType::int16:
      return number<std::int16_t>(at, swapped);
    case NumberType::uint16:
      return number<std::uint16_t>(at, swapped);
    case NumberType::int32:
      return number<std::int32_t>(at, swapped);
    case NumberType::uint32:
      return number<std::uint32_t>(at, swapped);
    case NumberType::float32:
      return number<float>(at, swapped);
    case NumberType::float64:
      break;
  }
  return number<double>(at, swapped);
}

constexpr std::string_view kBlanks = " \t\v\f\r";

bool is_blank(char c) { return kBlanks.find(c) != std::string_view::npos; }

/// NaN, in any spelling, is a number here: a point without a place.
double parse_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) return std::numeric_limits<double>::quiet_NaN();
  if (error != std::errc() || rest != word.data() + word.size()) {
    throw FileFault("'" + shown(word) + "' is not a number");
  }
  return value;
}

/// Calls use(k, word) for the words of a line up to column `last`; returns how many there were. Words are separated by
/// blanks, or by a comma or semicolon with blanks around.
template <typename Use>
std::size_t split(std::string_view line, std::size_t last, const Use& use) {
  std::size_t count = 0;
  std::size_t at = 0;
  const auto skip_blanks = [&] {
    while (at < line.size() && is_blank(line[at])) ++at;
  };
  for (skip_blanks(); at < line.size() && count <= last; ++count) {
    const std::size_t begin = at;
    while (at < line.size() && !is_blank(line[at]) && line[at] != ',' && line[at] != ';') ++at;
    use(count, line.substr(begin, at - begin));
    skip_blanks();
    if (at < line.size() && (line[at] == ',' || line[at] == ';')) ++at;
    skip_blanks();
  }
  return count;
}

/// What a line that begins as comments do has after that.
std::optional<std::string_view> comment_of(std::string_view line) {
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  for (const std::string_view mark : {"#", "//", "%"}) {
    if (line.starts_with(mark)) return line.substr(mark.size());
  }
  return std::nullopt;
}

std::string_view without_comment(std::string_view line) {
  return comment_of(line) ? std::string_view() : line.substr(0, line.find('#'));
}

bool is_empty(std::string_view line) { return std::all_of(line.begin(), line.end(), is_blank); }

std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

std::string lower(std::string_view word) {
  std::string text(word);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return text;
}

/// The names of a line, in small letters without quotes and without units in brackets.
std::vector<std::string> names_of(std::string_view line) {
  std::string plain;
  int depth = 0;
  for (const char c : lower(line)) {
    if (c == '(' || c == '[') ++depth;
    if (depth == 0 && c != '"') plain += c;
    if ((c == ')' || c == ']') && depth > 0) --depth;
  }
  std::vector<std::string> names;
  split(plain, std::numeric_limits<std::size_t>::max() - 1,
        [&](std::size_t, std::string_view word) { names.emplace_back(word); });
  return names;
}

/// Where names have x, y and z.
std::optional<std::array<std::size_t, 3>> named_columns(const std::vector<std::string>& names) {
  std::array<std::size_t, 3> columns{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto found = std::ranges::find(names, std::string(1, "xyz"[axis]));
    if (found == names.end()) return std::nullopt;
    columns[axis] = static_cast<std::size_t>(found - names.begin());
  }
  return columns;
}

/// Lines before the first point: comments, empty ones, what a spreadsheet separates by (sep=;), how many points follow.
struct Heading {
  std::size_t lines = 0;
  std::vector<std::string> names;  // of the last comment that has x, y and z
  std::optional<std::size_t> points;
};

bool is_number(std::string_view word) {
  try {
    static_cast<void>(parse_number(word));
    return true;
  } catch (const FileFault&) {
    return false;
  }
}

/// Takes one more line into the heading, unless points or names begin there.
bool take_heading(std::string_view line, Heading& heading) {
  if (const auto comment = comment_of(line)) {
    std::vector<std::string> names = names_of(*comment);
    if (named_columns(names)) heading.names = std::move(names);
    return true;
  }
  line = without_comment(line);
  if (is_empty(line) || lower(line).starts_with("sep=")) return true;
  std::size_t value = 0;
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  const auto [rest, error] = std::from_chars(line.data(), line.data() + line.size(), value);
  if (heading.points || error != std::errc() || rest != line.data() + line.size()) return false;
  heading.points = value;
  return true;
}

}  // namespace

std::size_t size_of(NumberType type) noexcept {
  switch (type) {
    case NumberType::int8:
    case NumberType::uint8:
      return 1;
    case NumberType::int16:
    case NumberType::uint16:
      return 2;
    case NumberType::float64:
      return 8;
    default:
      return 4;
  }
}

void require_records(std::string_view bytes, std::size_t count, std::size_t size) {
  if (size > 0 && count <= bytes.size() / size) return;
  throw FileFault("ends before its " + std::to_string(count) + " points do");
}

Coordinates read_columns(std::string_view bytes, const std::array<Column, 3>& columns, std::size_t count,
                         bool swapped) {
  if (count == 0) return {};
  for (const Column& column : columns) {
    const std::size_t width = size_of(column.type);
    // The last number must end within the bytes; written so that nothing overflows.
    if (column.offset > bytes.size() || width > bytes.size() - column.offset ||
        (column.stride > 0 && (count - 1) > (bytes.size() - column.offset - width) / column.stride)) {
      throw FileFault("ends before its " + std::to_string(count) + " points do");
    }
    if (column.stride == 0 && count > 1) throw FileFault("points of no size");
  }
  Coordinates points(count);
  for (std::size_t c = 0; c < 3; ++c) {
    const char* at = bytes.data() + columns[c].offset;
    for (std::size_t i = 0; i < count; ++i) points[i][c] = number(at + i * columns[c].stride, columns[c].type, swapped);
  }
  return points;
}

std::string shown(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text(word.substr(0, kLongest));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return word.size() > kLongest ? text + "..." : text;
}

std::size_t parse_count(std::string_view word, std::string_view of) {
  std::size_t value = 0;
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc() && rest == word.data() + word.size()) return value;
  throw FileFault("header: " + std::string(of) + " is '" + shown(word) + "', expected a whole number");
}

std::vector<std::string_view> take_line(std::string_view& text) {
  std::vector<std::string_view> words;
  std::string_view line = next_line(text);
  while (true) {
    const std::size_t begin = line.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    words.push_back(line.substr(0, line.find_first_of(kBlanks)));
    line.remove_prefix(words.back().size());
  }
}

Coordinates read_number_lines(std::string_view text, const std::array<std::size_t, 3>& columns, std::size_t count,
                              std::size_t before) {
  const std::size_t last = *std::max_element(columns.begin(), columns.end());
  Coordinates points;
  for (std::size_t number = before + 1; !text.empty() && points.size() < count; ++number) {
    const std::string_view line = without_comment(next_line(text));
    if (is_empty(line)) continue;
    try {
      if (line.find(';') != std::string_view::npos && line.find(',') != std::string_view::npos) {
        throw FileFault("commas and semicolons in one line: write numbers with points, or separate by one of them");
      }
      std::array<double, 3> point{};
      const std::size_t words = split(line, last, [&](std::size_t k, std::string_view word) {
        for (std::size_t c = 0; c < 3; ++c) {
          if (columns[c] == k) point[c] = parse_number(word);
        }
      });
      if (words <= last) {
        throw FileFault("expected " + std::to_string(last + 1) + " numbers or more, got " + std::to_string(words));
      }
      points.push_back(point);
    } catch (const FileFault& fault) {
      throw FileFault(std::to_string(number) + ": " + fault.what());
    }
  }
  return points;
}

Coordinates read_point_text(std::string_view text) {
  if (text.find('\n') == std::string_view::npos && text.find('\r') != std::string_view::npos) {
    std::string lines(text);  // as old Macs ended them
    std::replace(lines.begin(), lines.end(), '\r', '\n');
    return read_point_text(lines);
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  Heading heading;
  std::string_view rest = text;
  std::string_view line = next_line(rest);
  for (; !text.empty() && take_heading(line, heading); line = next_line(rest)) {
    ++heading.lines;
    text = rest;
  }
  std::array<std::size_t, 3> columns{0, 1, 2};
  std::size_t words = 0;
  bool numbers = true;
  split(without_comment(line), std::numeric_limits<std::size_t>::max() - 1, [&](std::size_t k, std::string_view word) {
    ++words;
    numbers = numbers && (k > 2 || is_number(word));
  });
  // A comment names columns where it has a word for each: prose hardly ever does.
  const std::vector<std::string> names = numbers ? heading.names : names_of(line);
  const auto named = named_columns(names);
  if (!numbers && !named) {
    throw FileFault(std::to_string(heading.lines + 1) + ": neither numbers nor a line of names with x, y and z: '" +
                    shown(line) + "'");
  }
  if (named && (!numbers || names.size() == words)) columns = *named;
  if (!numbers) {
    ++heading.lines;
    text = rest;
  }
  Coordinates points = read_number_lines(text, columns, std::numeric_limits<std::size_t>::max(), heading.lines);
  if (heading.points && *heading.points != points.size()) {
    throw FileFault("says that it has " + std::to_string(*heading.points) + " points, but has " +
                    std::to_string(points.size()));
  }
  return points;
}

Coordinates read_kitti(std::string_view bytes) {
  constexpr std::size_t kRow = 4 * sizeof(float);
  if (bytes.size() % kRow != 0) {
    throw FileFault(std::to_string(bytes.size()) + " bytes, expected rows of four float32 (x, y, z, reflectance)");
  }
  return read_columns(bytes, {Column{0, kRow}, Column{4, kRow}, Column{8, kRow}}, bytes.size() / kRow, false);
}

}  // namespace consimd::features::detail
