// The LAS form of airborne and terrestrial laser scans (ASPRS, "LAS specification 1.4", section 2.4).
#include <cmath>
#include <cstring>

#include "files/records.hpp"

namespace consimd::features::detail {
namespace {

template <typename T>
T value_at(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

}  // namespace

Coordinates read_las(std::string_view bytes) {
  constexpr std::size_t kHeader = 227;        // of versions 1.0 to 1.2; later ones are longer
  constexpr std::size_t kLongHeader = 255;    // of version 1.4, to the end of the number of points
  constexpr std::uint8_t kCompressed = 0x80;  // set by LASzip in the format of a point
  if (!bytes.starts_with("LASF")) throw FileFault("not a LAS file");
  if (bytes.size() < kHeader) throw FileFault("ends within its header");
  const auto minor = value_at<std::uint8_t>(bytes, 25);
  const auto offset = value_at<std::uint32_t>(bytes, 96);
  if ((value_at<std::uint8_t>(bytes, 104) & kCompressed) != 0) {
    throw FileFault(
        "compressed as LAZ, which is not read: unpack it with 'pdal translate FILE.laz FILE.las' or 'laspy decompress "
        "FILE.laz'");
  }
  const auto record = std::size_t{value_at<std::uint16_t>(bytes, 105)};
  std::uint64_t count = value_at<std::uint32_t>(bytes, 107);
  if (minor >= 4) {
    if (bytes.size() < kLongHeader) throw FileFault("ends within its header");
    count = value_at<std::uint64_t>(bytes, 247);
  }
  if (offset > bytes.size() || record < 12) throw FileFault("header: points of no size, or beyond the end");
  std::array<double, 3> scale{}, shift{};
  for (std::size_t c = 0; c < 3; ++c) {
    scale[c] = value_at<double>(bytes, 131 + 8 * c);
    shift[c] = value_at<double>(bytes, 155 + 8 * c);
    if (!std::isfinite(scale[c]) || !std::isfinite(shift[c])) throw FileFault("header: a scale that is not finite");
  }
  const std::string_view points = bytes.substr(offset);
  if (count > points.size() / record) throw FileFault("ends before its " + std::to_string(count) + " points do");
  Coordinates rows = read_columns(points,
                                  {Column{0, record, NumberType::int32}, Column{4, record, NumberType::int32},
                                   Column{8, record, NumberType::int32}},
                                  static_cast<std::size_t>(count), false);
  for (auto& row : rows) {
    for (std::size_t c = 0; c < 3; ++c) row[c] = row[c] * scale[c] + shift[c];
  }
  return rows;
}

}  // namespace consimd::features::detail
