#include <consimd/studies/value_list.hpp>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fmt/format.h>

namespace consimd::studies {
namespace {

constexpr std::uint32_t kMostValues = 100'000;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::vector<double> evenly_spaced(std::string_view text, const std::vector<std::string_view>& parts) {
  std::uint32_t count = 0;
  bool valid = parts.size() == 3;
  if (valid) {
    const char* end = parts[2].data() + parts[2].size();
    const auto [rest, error] = std::from_chars(parts[2].data(), end, count);
    valid = error == std::errc() && rest == end && count >= 2 && count <= kMostValues;
  }
  if (!valid) {
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
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !std::isfinite(value)) {
    throw std::invalid_argument(fmt::format("'{}' is not a finite number", text));
  }
  return value;
}

std::vector<double> parse_value_list(std::string_view text) {
  if (text.find(':') != std::string_view::npos) return evenly_spaced(text, split(text, ':'));
  std::vector<double> values;
  for (const std::string_view part : split(text, ',')) values.push_back(parse_number(part));
  return values;
}

}  // namespace consimd::studies
