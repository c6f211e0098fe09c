#include "files/records.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "text/words.hpp"

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

std::size_t parse_count(std::string_view word, std::string_view of) {
  if (const auto value = text::number_in<std::size_t>(word)) return *value;
  throw FileFault("header: " + std::string(of) + " is '" + text::shown(word) + "', expected a whole number");
}

Coordinates read_kitti(std::string_view bytes) {
  constexpr std::size_t kRow = 4 * sizeof(float);
  if (bytes.size() % kRow != 0) {
    throw FileFault(std::to_string(bytes.size()) + " bytes, expected rows of four float32 (x, y, z, reflectance)");
  }
  return read_columns(bytes, {Column{0, kRow}, Column{4, kRow}, Column{8, kRow}}, bytes.size() / kRow, false);
}

}  // namespace consimd::features::detail
