#include "files/records.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>

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

std::string_view without_comment(std::string_view line) { return line.substr(0, line.find('#')); }

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

/// Where a line of names has x, y and z.
std::array<std::size_t, 3> named_columns(std::string_view line) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::array<std::size_t, 3> columns{kNone, kNone, kNone};
  split(line, 1000, [&](std::size_t k, std::string_view word) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::string name = lower(word);
      std::erase(name, '"');
      if (name == std::string(1, "xyz"[axis])) columns[axis] = k;
    }
  });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (columns[axis] == kNone) {
      throw FileFault("1: neither numbers nor a line of names with x, y and z: '" + shown(line) + "'");
    }
  }
  return columns;
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
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::string_view rest = text;
  std::size_t before = 0;
  std::string_view first;
  while (is_empty(without_comment(first)) && !rest.empty()) {
    text = rest;
    first = next_line(rest);
    ++before;
  }
  bool numbers = true;
  split(without_comment(first), 2, [&](std::size_t, std::string_view word) {
    try {
      static_cast<void>(parse_number(word));
    } catch (const FileFault&) {
      numbers = false;
    }
  });
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  if (numbers) return read_number_lines(text, {0, 1, 2}, kAll, before - (before > 0 ? 1 : 0));
  return read_number_lines(rest, named_columns(first), kAll, before);
}

Coordinates read_kitti(std::string_view bytes) {
  constexpr std::size_t kRow = 4 * sizeof(float);
  if (bytes.size() % kRow != 0) {
    throw FileFault(std::to_string(bytes.size()) + " bytes, expected rows of four float32 (x, y, z, reflectance)");
  }
  return read_columns(bytes, {Column{0, kRow}, Column{4, kRow}, Column{8, kRow}}, bytes.size() / kRow, false);
}

}  // namespace consimd::features::detail
