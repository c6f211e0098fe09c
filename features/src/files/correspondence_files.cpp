#include <consimd/features/correspondence_files.hpp>

#include <charconv>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "files/records.hpp"

namespace consimd::features {
namespace {

detail::Coordinates rows_of(const std::filesystem::path& path) {
  try {
    return detail::read_points(detail::contents(path), path);
  } catch (const detail::FileFault& fault) {
    throw detail::named(path, fault);
  }
}

/// The words of a line between blanks and commas, without its comment.
std::vector<std::string> words_of(std::string_view& text) {
  std::vector<std::string> words(1);
  bool comment = false;
  while (!text.empty()) {
    const char c = text.front();
    text.remove_prefix(1);
    if (c == '\n') break;
    comment = comment || c == '#';
    if (comment) continue;
    if (c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';') {
      if (!words.back().empty()) words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

std::size_t row_number(const std::string& word, std::size_t rows, const char* side) {
  std::size_t row = 0;
  const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), row);
  if (error != std::errc() || rest != word.data() + word.size()) {
    throw detail::FileFault("'" + detail::shown(word) + "' is no row of the " + side + ", a number from 0 on");
  }
  if (row >= rows) {
    throw detail::FileFault("row " + std::to_string(row) + " of the " + side + ", which has " + std::to_string(rows));
  }
  return row;
}

}  // namespace

Correspondences MatchedPoints::correspondences() const {
  const auto span = [](const std::vector<std::array<double, 3>>& points) {
    return PointSpan<double>::interleaved(points.empty() ? nullptr : points.front().data(), points.size());
  };
  return {span(source), span(target)};
}

MatchedPoints read_array_matches(const std::filesystem::path& path) {
  try {
    const std::string bytes = detail::contents(path);
    const bool is_one = bytes.starts_with("\x93NUMPY");
    auto [source, target] = is_one ? detail::read_npy_matches(bytes) : detail::read_npz_matches(bytes);
    return {std::move(source), std::move(target)};
  } catch (const detail::FileFault& fault) {
    throw detail::named(path, fault);
  }
}

MatchedPoints read_matched_rows(const std::filesystem::path& source, const std::filesystem::path& target) {
  MatchedPoints matches{rows_of(source), rows_of(target)};
  if (matches.source.size() == matches.target.size()) return matches;
  throw std::runtime_error(target.string() + ": " + std::to_string(matches.target.size()) + " rows, expected " +
                           std::to_string(matches.source.size()) + " as in " + source.string());
}

MatchedPoints read_indexed_matches(const std::filesystem::path& source, const std::filesystem::path& target,
                                   const std::filesystem::path& pairs) {
  const detail::Coordinates from = rows_of(source), to = rows_of(target);
  const std::string bytes = detail::contents(pairs);
  std::string_view text = bytes;
  MatchedPoints matches;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::vector<std::string> words = words_of(text);
    if (words.empty()) continue;
    try {
      if (words.size() < 2) throw detail::FileFault("expected a row of the source and one of the target");
      matches.source.push_back(from[row_number(words[0], from.size(), "source")]);
      matches.target.push_back(to[row_number(words[1], to.size(), "target")]);
    } catch (const detail::FileFault& fault) {
      throw std::runtime_error(pairs.string() + ":" + std::to_string(line) + ": " + fault.what());
    }
  }
  return matches;
}

}  // namespace consimd::features
