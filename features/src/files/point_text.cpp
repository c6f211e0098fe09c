// Points in lines of text, as many programs write them.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "files/records.hpp"
#include "text/words.hpp"

namespace consimd::features::detail {
namespace {

constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
constexpr const char* kChoose =
    ": say which are x, y and z, counted from 1 ('register' and 'match' take --columns 2,3,4)";

/// NaN, in any spelling, and what is beyond a double's range are coordinates too: of a point without a place.
std::optional<double> coordinate_in(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0.0;
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) return std::numeric_limits<double>::quiet_NaN();
  if (error != std::errc() || rest != word.data() + word.size()) return std::nullopt;
  return value;
}

double parse_number(std::string_view word) {
  if (const auto value = coordinate_in(word)) return *value;
  throw FileFault("'" + text::shown(word) + "' is not a number");
}

/// Calls use(k, word) for the words of a line up to number `last`, without blanks or quotes around; returns how many
/// there were.
template <typename Use>
std::size_t for_each_word(std::string_view line, char separator, std::size_t last, const Use& use) {
  std::size_t count = 0;
  if (separator != '\t') line = text::trimmed(line);
  if (line.empty()) return 0;
  for (bool more = true; more && count <= last; ++count) {
    const std::size_t begin = separator == '\t' ? 0 : std::min(line.find_first_not_of(text::kBlanks), line.size());
    line.remove_prefix(begin);
    const std::size_t quoted = text::quoted_length(line);
    std::size_t end = quoted;
    while (end < line.size() && (separator == ' ' ? !text::is_blank(line[end]) : line[end] != separator)) ++end;
    const std::string_view word = text::trimmed(line.substr(0, end));
    use(count, word.size() > 1 && word.size() == quoted ? word.substr(1, quoted - 2) : word);
    more = end < line.size();
    line.remove_prefix(more ? end + 1 : end);
    if (separator == ' ') more = more && line.find_first_not_of(text::kBlanks) != std::string_view::npos;
  }
  return count;
}

/// The names of a line, in small letters, without units in brackets or behind a slash.
std::vector<std::string> names_of(std::string_view line, char separator) {
  std::string plain;
  int depth = 0;
  for (const char c : text::lower(line)) {
    if (c == '(' || c == '[') ++depth;
    if (depth == 0) plain += c;
    if ((c == ')' || c == ']') && depth > 0) --depth;
  }
  std::vector<std::string> names;
  for_each_word(plain, separator, kAll, [&](std::size_t, std::string_view word) {
    names.emplace_back(text::trimmed(word.substr(0, word.find('/'))));
  });
  return names;
}

/// A name without the axis at its end, or at its beginning before a mark; none where it has no such axis.
std::optional<std::pair<std::size_t, std::string>> axis_and_stem(const std::string& name) {
  constexpr std::string_view kAxes = "xyz";
  if (name.empty()) return std::nullopt;
  if (const std::size_t axis = kAxes.find(name.back()); axis != std::string_view::npos) {
    return std::pair(axis, name.substr(0, name.size() - 1));
  }
  const std::size_t axis = kAxes.find(name.front());
  if (axis == std::string_view::npos || name.size() < 2 || (name[1] != '_' && name[1] != '.')) return std::nullopt;
  return std::pair(axis, name.substr(1));
}

using Columns = std::array<std::size_t, 3>;

/// Where names have x, y and z, or else the one triple like them, as tx ty tz, that is no normal and no quaternion.
std::optional<Columns> named_columns(const std::vector<std::string>& names) {
  struct Triple {
    std::string stem;
    Columns columns{kAll, kAll, kAll};
  };
  std::vector<Triple> triples;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto named = axis_and_stem(names[k]);
    if (!named) continue;
    auto triple = std::ranges::find(triples, named->second, &Triple::stem);
    if (triple == triples.end()) triple = triples.insert(triples.end(), {named->second, {kAll, kAll, kAll}});
    if (triple->columns[named->first] == kAll) triple->columns[named->first] = k;
  }
  std::erase_if(triples, [](const Triple& triple) {
    return std::ranges::find(triple.columns, kAll) != triple.columns.end() || triple.stem.starts_with('n') ||
           triple.stem.starts_with('q');
  });
  const auto plain = std::ranges::find(triples, std::string(), &Triple::stem);
  if (plain != triples.end()) return plain->columns;
  return triples.size() == 1 ? std::optional(triples.front().columns) : std::nullopt;
}

/// Names of columns in a comment.
struct CommentedNames {
  std::vector<std::string> names;
  bool is_list = false;  // separated by more than blanks, which prose is not
};

/// Lines before the first point: comments, empty ones, what a spreadsheet separates by (sep=;), how many points follow.
struct Heading {
  std::size_t lines = 0;
  std::optional<CommentedNames> commented;  // the last names that tell x, y and z
  std::optional<std::size_t> points;
};

/// Takes one more line into the heading, unless points or names begin there.
bool take_heading(std::string_view line, Heading& heading) {
  if (const auto comment = text::comment_of(line)) {
    const char separator = text::separator_of(*comment, true);
    std::vector<std::string> names = names_of(*comment, separator);
    if (named_columns(names)) heading.commented = {std::move(names), separator != ' '};
    return true;
  }
  line = text::trimmed(line);
  if (line.empty() || (line.size() == 5 && text::lower(line).starts_with("sep="))) return true;
  if (heading.points) return false;
  heading.points = text::number_in<std::size_t>(line);
  return heading.points.has_value();
}

/// The words of a line; an empty one behind a last separator is none.
std::vector<std::string_view> words_in(std::string_view line, bool tabs) {
  std::vector<std::string_view> words;
  line = text::without_comment(line);
  for_each_word(line, text::separator_of(line, tabs), kAll,
                [&](std::size_t, std::string_view word) { words.push_back(word); });
  if (!words.empty() && words.back().empty()) words.pop_back();
  return words;
}

/// Whether rows have names of their own, which the names of the columns do not count: first words that are no number,
/// or count from 0 or 1.
bool are_named(const std::vector<std::string_view>& first, const std::vector<std::string_view>& second) {
  const std::optional<double> number = coordinate_in(first[0]);
  if (!number) return true;
  return (*number == 0.0 || *number == 1.0) && (second.empty() || coordinate_in(second[0]) == *number + 1.0);
}

/// Columns that a line of names tells, held against the words of the first two points.
Columns told_by(const std::vector<std::string>& names, Columns columns, const std::vector<std::string_view>& first,
                const std::vector<std::string_view>& second, bool is_list) {
  if (first.size() == names.size() + 1) {
    if (!are_named(first, second)) return columns;
    for (std::size_t& column : columns) ++column;
  } else if (first.size() != names.size() && !is_list) {
    throw FileFault(std::to_string(first.size()) + " words, but " + std::to_string(names.size()) + " names before");
  }
  return columns;
}

/// Takes the words of the next point.
std::vector<std::string_view> take_point(std::string_view& text, bool tabs) {
  std::vector<std::string_view> words;
  while (words.empty() && !text.empty()) words = words_in(text::take_line(text), tabs);
  return words;
}

/// The next line that holds more than a comment.
std::string_view first_row(std::string_view text) {
  std::string_view line;
  while (!text.empty() && text::trimmed(line).empty()) line = text::without_comment(text::take_line(text));
  return line;
}

/// Whether tabs separate the words of a row: they part all coordinates. Between tabs there may be blanks, as in names.
bool separates_by_tabs(std::string_view row, const Columns& columns) {
  std::size_t found = 0;
  for_each_word(row, '\t', kAll, [&](std::size_t k, std::string_view word) {
    if (std::ranges::find(columns, k) != columns.end() && coordinate_in(word)) ++found;
  });
  return found == columns.size();
}

/// Whether a word begins as the name of a column does, and does not stand for a number that is missing.
bool is_name(std::string_view word) {
  constexpr std::array<std::string_view, 5> kMissing{"na", "n/a", "nan", "null", "none"};
  const std::string small = text::lower(word);
  if (small.empty() || std::ranges::find(kMissing, small) != kMissing.end()) return false;
  return (small[0] >= 'a' && small[0] <= 'z') || static_cast<unsigned char>(small[0]) >= 0x80;
}

/// Whether a first line has names where the coordinates are to be. Behind a count it may be any remark, as in a
/// molecule's file, that is no point.
bool names_columns(std::string_view line, const Columns& columns, bool is_behind_count) {
  const std::vector<std::string_view> words = words_in(line, true);
  const auto is_there = [&](std::size_t column) { return column < words.size(); };
  const auto there = std::ranges::count_if(columns, is_there);
  const auto names =
      std::ranges::count_if(columns, [&](std::size_t column) { return is_there(column) && is_name(words[column]); });
  if (!is_behind_count) return names > 0 && names == there;
  return names > 0 || (std::ranges::max(columns) >= words.size() && std::ranges::any_of(words, is_name));
}

/// Whether a first line numbers the columns, as pandas does for an array without names: other rows have fractions.
bool numbers_columns(const std::vector<std::string_view>& words, const Coordinates& points) {
  const std::size_t before = !words.empty() && words[0].empty() ? 1 : 0;  // of an index
  for (std::size_t k = before; k < words.size(); ++k) {
    if (words[k] != std::to_string(k - before)) return false;
  }
  return words.size() >= before + 3 && std::ranges::any_of(points, [](const auto& point) {
           return std::ranges::any_of(point, [](double x) { return x != std::floor(x); });
         });
}

/// Whether the first numbers count the rows, from 0 or 1. Of a few rows that may be chance.
bool count_rows(const Coordinates& points) {
  constexpr std::size_t kFewest = 8;
  if (points.size() < kFewest || (points[0][0] != 0.0 && points[0][0] != 1.0)) return false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i][0] != points[0][0] + static_cast<double>(i)) return false;
  }
  return true;
}

/// A number whose point is a comma.
bool has_decimal_comma(std::string_view word) {
  const std::size_t comma = word.find(',');
  if (comma == std::string_view::npos || comma == 0 || comma + 1 == word.size()) return false;
  std::string plain(word);
  plain[comma] = '.';
  return coordinate_in(plain).has_value();
}

/// What a line's commas make of it where they are decimal ones, in words between semicolons or where blanks separate
/// numbers; else what it was told.
std::string told_of(std::string_view line, const std::string& what) {
  const bool semicolons = line.find(';') != std::string_view::npos;
  bool all = true;
  bool some = false;
  for_each_word(line, semicolons ? ';' : ' ', kAll, [&](std::size_t, std::string_view word) {
    some = some || has_decimal_comma(word);
    all = all && (has_decimal_comma(word) || coordinate_in(word));
  });
  return some && (all || semicolons) ? std::string("decimal commas: ") + text::kDecimalPoints : what;
}

Coordinates lines_of_points(std::string_view text, const Columns& columns, std::size_t count, std::size_t before,
                            bool tabs) {
  const std::size_t last = std::ranges::max(columns);
  Coordinates points;
  for (std::size_t number = before + 1; !text.empty() && points.size() < count; ++number) {
    const std::string_view line = text::without_comment(text::take_line(text));
    if (text::trimmed(line).empty()) continue;
    try {
      std::array<double, 3> point{};
      const std::size_t words =
          for_each_word(line, text::separator_of(line, tabs), last, [&](std::size_t k, std::string_view word) {
            for (std::size_t c = 0; c < 3; ++c) {
              if (columns[c] == k) point[c] = parse_number(word);
            }
          });
      if (words <= last) {
        throw FileFault("expected " + std::to_string(last + 1) + " numbers or more, got " + std::to_string(words));
      }
      points.push_back(point);
    } catch (const FileFault& fault) {
      throw FileFault(std::to_string(number) + ": " + told_of(line, fault.what()));
    }
  }
  return points;
}

}  // namespace

std::optional<std::string> with_line_feeds(std::string_view text) {
  std::optional<std::string> lines;
  for (std::size_t at = text.find('\r'); at != std::string_view::npos; at = text.find('\r', at + 1)) {
    if (at + 1 == text.size() || text[at + 1] == '\n') continue;
    if (!lines) lines = std::string(text);
    (*lines)[at] = '\n';
  }
  return lines;
}

std::vector<std::string_view> words_between_blanks(std::string_view line) {
  std::vector<std::string_view> words;
  for_each_word(line, ' ', kAll, [&](std::size_t, std::string_view word) { words.push_back(word); });
  return words;
}

std::vector<std::string_view> words_of_row(std::string_view line) { return words_in(line, true); }

Coordinates read_number_lines(std::string_view text, const std::array<std::size_t, 3>& columns, std::size_t count,
                              std::size_t before) {
  return lines_of_points(text, columns, count, before, false);
}

Coordinates read_point_text(std::string_view text, const std::optional<Columns>& chosen) {
  if (const auto lines = with_line_feeds(text)) return read_point_text(*lines, chosen);
  text = text::without_mark(text);
  Heading heading;
  std::string_view rest = text;
  std::string_view line = text::take_line(rest);
  for (; !text.empty() && take_heading(line, heading); line = text::take_line(rest)) {
    ++heading.lines;
    text = rest;
  }
  const auto fault = [&](const std::string& what) {
    return FileFault(std::to_string(heading.lines + 1) + ": " + what);
  };
  Columns columns{0, 1, 2};
  bool tabs = false;
  bool told = false;
  std::vector<std::string_view> words = words_in(line, false);
  const bool numbers = std::ranges::all_of(
      words.begin(), words.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(words.size(), 3)),
      [](std::string_view word) { return coordinate_in(word).has_value(); });
  const std::vector<std::string> names =
      numbers ? std::vector<std::string>() : names_of(line, text::separator_of(line, true));
  const std::optional<Columns> named = named_columns(names);
  try {
    if (chosen) {
      const bool has_names = names_columns(line, *chosen, heading.points.has_value());
      std::string_view after = text;
      if (has_names) {
        ++heading.lines;
        after = text = rest;
      }
      tabs = (has_names && line.find('\t') != std::string_view::npos) || separates_by_tabs(first_row(after), *chosen);
      columns = *chosen;
      told = true;
    } else if (named) {
      const char separator = text::separator_of(line, true);
      tabs = separator == '\t';
      std::string_view after = rest;
      words = take_point(after, tabs);
      const std::vector<std::string_view> second = take_point(after, tabs);
      ++heading.lines;
      text = rest;
      columns = words.empty() ? *named : told_by(names, *named, words, second, separator != ' ');
      told = true;
    } else if (heading.commented) {
      // A comment names columns where it has a word for each, or is a list: prose hardly ever does.
      const auto& [commented, is_list] = *heading.commented;
      const Columns found = *named_columns(commented);
      told = commented.size() == words.size() || (is_list && std::ranges::max(found) < words.size());
      if (told) columns = found;
    }
  } catch (const FileFault& mismatch) {
    throw fault(mismatch.what());
  }
  if (!numbers && !told) {
    throw fault(told_of(text::without_comment(line),
                        "neither numbers nor a line of names with x, y and z: '" + text::shown(line) + "'" + kChoose));
  }
  Coordinates points = lines_of_points(text, columns, kAll, heading.lines, tabs);
  if (!told && words.size() > 3 && count_rows(points)) {
    points = lines_of_points(text, {1, 2, 3}, kAll, heading.lines, tabs);
  }
  if ((!told || chosen) && numbers_columns(words, points)) points.erase(points.begin());
  if (heading.points && *heading.points != points.size()) {
    throw FileFault("says that it has " + std::to_string(*heading.points) + " points, but has " +
                    std::to_string(points.size()));
  }
  return points;
}

}  // namespace consimd::features::detail
