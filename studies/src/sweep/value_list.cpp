#include <consimd/studies/value_list.hpp>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "text/words.hpp"

namespace consimd::studies {
namespace {

constexpr std::uint32_t kMostValues = 100'000;

std::vector<double> evenly_spaced(std::string_view text, const std::vector<std::string_view>& parts) {
  const std::uint32_t count = parts.size() == 3 ? text::number_in<std::uint32_t>(parts[2]).value_or(0) : 0;
  if (count < 2 || count > kMostValues) {
    throw std::invalid_argument(
        fmt::format("'{}': expected start:end:count with a count from 2 to {}", text, kMostValues));
  }
  const double first = parse_number(parts[0]);
  const double last = parse_number(parts[1]);
  if (!(first < last)) throw std::invalid_argument(fmt::format("'{}': the start must be below the end", text));

  std::vector<double> values;
  values.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    values.push_back(parse_number(fmt::format("{:.12g}", first + (last - first) * i / (count - 1))));
  }
  return values;
}

}  // namespace

double parse_number(std::string_view text) {
  const auto value = text::number_in<double>(text);
  if (!value || !std::isfinite(*value)) throw std::invalid_argument(fmt::format("'{}' is not a finite number", text));
  return *value;
}

std::vector<double> parse_value_list(std::string_view text) {
  if (text.find(':') != std::string_view::npos) return evenly_spaced(text, text::split(text, ':'));
  std::vector<double> values;
  for (const std::string_view part : text::split(text, ',')) values.push_back(parse_number(part));
  return values;
}

}  // namespace consimd::studies
