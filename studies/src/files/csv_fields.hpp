// Reading a line of one of the study's tables.
#pragma once

#include <charconv>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace consimd::studies {

/// Takes the fields of a line from left to right. Throws std::invalid_argument that says what is wrong.
class CsvFields {
 public:
  explicit CsvFields(std::string_view line) : rest_(line) {}

  std::string_view text() {
    if (exhausted_) throw std::invalid_argument("too few columns");
    const std::size_t comma = rest_.find(',');
    const std::string_view field = rest_.substr(0, comma);
    exhausted_ = comma == std::string_view::npos;
    if (!exhausted_) rest_.remove_prefix(comma + 1);
    return field;
  }

  template <typename T>
  T number() {
    const std::string_view field = text();
    T value{};
    const char* end = field.data() + field.size();
    const auto [rest, error] = std::from_chars(field.data(), end, value);
    if (error != std::errc() || rest != end) throw std::invalid_argument(fmt::format("bad value '{}'", field));
    return value;
  }

  void finish() const {
    if (!exhausted_) throw std::invalid_argument("too many columns");
  }

 private:
  std::string_view rest_;
  bool exhausted_ = false;
};

}  // namespace consimd::studies
