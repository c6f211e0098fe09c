#include "scans/text_rows.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <Eigen/Core>

#include <fmt/format.h>

#include <consimd/synth/problem_files.hpp>
#include <consimd/synth/text_file.hpp>

#include "text/words.hpp"

namespace consimd::studies {
namespace {

std::vector<std::string> words_of(std::string_view line, std::string_view separators) {
  std::vector<std::string> words;
  const bool may_be_empty = separators.find_first_not_of(text::kBlanks) != std::string_view::npos;
  for (const std::string_view part : text::split(line, separators)) {
    const std::string_view word = text::trimmed(part);
    if (!word.empty() || may_be_empty) words.emplace_back(word);
  }
  return words;
}

template <typename Number>
bool parse(std::string_view text, Number& number) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto value = text::number_in<Number>(text);
  if (value) number = *value;
  return value.has_value();
}

}  // namespace

TextRows::TextRows(std::filesystem::path path, std::string_view separators) : path_(std::move(path)) {
  const std::string text = synth::read_text(path_);
  std::string_view rest = text::without_mark(text);
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::string_view line = text::take_line(rest);
    const std::string_view content = text::trimmed(line.substr(0, line.find('#')));
    if (!content.empty()) rows_.push_back({number, words_of(content, separators)});
  }
}

double TextRows::number(const TextRow& row, std::size_t word) const {
  double value = 0.0;
  if (word < row.words.size() && parse(row.words[word], value) && std::isfinite(value)) return value;
  fail(row, fmt::format("expected a finite number, got '{}'", word < row.words.size() ? row.words[word] : ""));
}

std::uint32_t TextRows::whole_number(const TextRow& row, std::size_t word) const {
  std::uint32_t value = 0;
  if (word < row.words.size() && parse(row.words[word], value)) return value;
  fail(row, fmt::format("expected a whole number, got '{}'", word < row.words.size() ? row.words[word] : ""));
}

void TextRows::require_words(const TextRow& row, std::size_t count) const {
  if (row.words.size() != count) fail(row, fmt::format("expected {} values, got {}", count, row.words.size()));
}

RigidTransform TextRows::pose(const TextRow& row, std::size_t first) const {
  const std::size_t count = row.words.size() - std::min(first, row.words.size());
  if (count != 12 && count != 16) fail(row, fmt::format("expected a pose of 12 or 16 numbers, got {}", count));
  std::vector<double> numbers;
  numbers.reserve(count);
  for (std::size_t k = 0; k < count; ++k) numbers.push_back(number(row, first + k));
  return checked_pose(row, numbers);
}

RigidTransform TextRows::pose_of_rows(std::size_t first, std::size_t count) const {
  std::vector<double> numbers;
  for (std::size_t k = first; k < first + count; ++k) {
    if (k >= rows_.size()) fail(fmt::format("ends within the pose that begins in line {}", rows_[first].line));
    require_words(rows_[k], 4);
    for (std::size_t c = 0; c < 4; ++c) numbers.push_back(number(rows_[k], c));
  }
  return checked_pose(rows_[first], numbers);
}

RigidTransform TextRows::checked_pose(const TextRow& row, const std::vector<double>& numbers) const {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(numbers.data());
  if (numbers.size() == 16) {
    constexpr double kRounding = 1e-6;  // as in the files that synth::read_pose reads
    const bool last = std::abs(numbers[12]) <= kRounding && std::abs(numbers[13]) <= kRounding &&
                      std::abs(numbers[14]) <= kRounding && std::abs(numbers[15] - 1.0) <= kRounding;
    if (!last) fail(row, "the last row of the pose must be 0 0 0 1");
  }
  try {
    return synth::nearest_pose(matrix.leftCols<3>(), matrix.col(3));
  } catch (const std::invalid_argument& error) {
    fail(row, error.what());
  }
}

void TextRows::fail(const std::string& what) const {
  throw std::runtime_error(fmt::format("{}: {}", path_.string(), what));
}

void TextRows::fail(const TextRow& row, const std::string& what) const {
  throw std::runtime_error(fmt::format("{}:{}: {}", path_.string(), row.line, what));
}

}  // namespace consimd::studies
