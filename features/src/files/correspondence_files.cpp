#include <consimd/features/correspondence_files.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/records.hpp"
#include "text/words.hpp"

namespace consimd::features {
namespace {

/// The points of the source, side 0, or the target.
detail::Coordinates rows_of(const std::filesystem::path& path, const std::optional<PairColumns>& columns,
                            std::size_t side) {
  try {
    return detail::read_points(detail::contents(path), path, columns ? std::optional((*columns)[side]) : std::nullopt);
  } catch (const detail::FileFault& fault) {
    throw detail::named(path, fault);
  }
}

std::size_t row_number(std::string_view word, std::size_t rows, const char* side) {
  // 39.0 and 3.9e1 are rows, as NumPy's savetxt writes them.
  const double value = text::number_in<double>(word).value_or(-1.0);
  if (!(value >= 0.0) || value != std::floor(value)) {
    throw detail::FileFault("'" + text::shown(word) + "' is no row of the " + side + ", a whole number from 0 on");
  }
  if (value >= static_cast<double>(rows)) {
    throw detail::FileFault("row " + text::shown(word) + " of the " + side + ", which has " + std::to_string(rows) +
                            ", counted from 0");
  }
  return static_cast<std::size_t>(value);
}

/// Where the words of a heading have source and target.
std::optional<std::array<std::size_t, 2>> named_sides(const std::vector<std::string_view>& words) {
  constexpr std::array<std::array<std::string_view, 3>, 2> kNames{
      {{"source", "src", "moving"}, {"target", "tgt", "ref"}}};
  std::array<std::optional<std::size_t>, 2> found;
  for (std::size_t k = 0; k < words.size(); ++k) {
    for (std::size_t side = 0; side < 2; ++side) {
      const auto begins = [word = text::lower(words[k])](std::string_view name) { return word.starts_with(name); };
      if (!found[side] && std::ranges::any_of(kNames[side], begins)) found[side] = k;
    }
  }
  if (!found[0] || !found[1]) return std::nullopt;
  return std::array{*found[0], *found[1]};
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

MatchedPoints read_matched_rows(const std::filesystem::path& source, const std::filesystem::path& target,
                                const std::optional<PairColumns>& columns) {
  MatchedPoints matches{rows_of(source, columns, 0), rows_of(target, columns, 1)};
  if (matches.source.empty()) throw std::runtime_error(source.string() + ": holds no points");
  if (matches.source.size() == matches.target.size()) return matches;
  throw std::runtime_error(target.string() + ": " + std::to_string(matches.target.size()) + " rows, expected " +
                           std::to_string(matches.source.size()) + " as in " + source.string());
}

MatchedPoints read_indexed_matches(const std::filesystem::path& source, const std::filesystem::path& target,
                                   const std::filesystem::path& pairs, const std::optional<PairColumns>& columns) {
  const detail::Coordinates from = rows_of(source, columns, 0), to = rows_of(target, columns, 1);
  std::string bytes = detail::contents(pairs);
  if (auto lines = detail::with_line_feeds(bytes)) bytes = std::move(*lines);
  std::string_view text = text::without_mark(bytes);
  MatchedPoints matches;
  std::array<std::size_t, 2> places{0, 1};
  std::optional<std::array<std::size_t, 2>> commented;
  std::size_t names_before = 0;
  bool is_first = true;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::string_view row = text::take_line(text);
    if (const auto comment = text::comment_of(row)) {
      const std::vector<std::string_view> words = detail::words_of_row(*comment);
      if (const auto sides = named_sides(words); sides && is_first) {
        commented = sides;
        names_before = words.size();
      }
      continue;
    }
    const std::vector<std::string_view> words = detail::words_of_row(row);
    if (words.empty()) continue;
    try {
      if (words.size() < 2) throw detail::FileFault("expected a row of the source and one of the target");
      if (std::exchange(is_first, false)) {
        if (const auto sides = named_sides(words)) {
          places = *sides;
          continue;
        }
        if (commented && names_before == words.size()) places = *commented;
      }
      if (std::max(places[0], places[1]) >= words.size()) throw detail::FileFault("fewer words than names before");
      matches.source.push_back(from[row_number(words[places[0]], from.size(), "source")]);
      matches.target.push_back(to[row_number(words[places[1]], to.size(), "target")]);
    } catch (const detail::FileFault& fault) {
      throw std::runtime_error(pairs.string() + ":" + std::to_string(line) + ": " + fault.what());
    }
  }
  if (matches.source.empty()) throw std::runtime_error(pairs.string() + ": holds no pairs");
  return matches;
}

}  // namespace consimd::features
