// The PCD form of the Point Cloud Library, version 0.7.
#include <cstring>

#include "files/records.hpp"
#include "text/words.hpp"

namespace consimd::features::detail {
namespace {

struct Header {
  std::vector<std::string_view> fields;
  std::vector<std::string_view> sizes;
  std::vector<std::string_view> types;
  std::vector<std::string_view> counts;
  std::string_view points;
  std::string_view width;
  std::string_view height = "1";
  std::string_view data;
  std::size_t lines = 0;
};

/// Takes the header off the bytes.
Header take_header(std::string_view& bytes) {
  Header header;
  while (header.data.empty()) {
    if (bytes.empty()) throw FileFault("header without DATA");
    std::vector<std::string_view> words = words_between_blanks(text::take_line(bytes));
    ++header.lines;
    if (words.size() < 2) continue;
    const std::string_view key = words[0];
    const std::string_view value = words[1];
    words.erase(words.begin());
    if (key == "FIELDS") header.fields = words;
    if (key == "SIZE") header.sizes = words;
    if (key == "TYPE") header.types = words;
    if (key == "COUNT") header.counts = words;
    if (key == "POINTS") header.points = value;
    if (key == "WIDTH") header.width = value;
    if (key == "HEIGHT") header.height = value;
    if (key == "DATA") header.data = value;
  }
  if (header.counts.empty()) header.counts.assign(header.fields.size(), "1");
  if (header.sizes.size() != header.fields.size() || header.types.size() != header.fields.size() ||
      header.counts.size() != header.fields.size()) {
    throw FileFault("header: FIELDS, SIZE, TYPE and COUNT of different lengths");
  }
  return header;
}

NumberType number_type(std::string_view type, std::size_t size) {
  if (type == "F" && size == 4) return NumberType::float32;
  if (type == "F" && size == 8) return NumberType::float64;
  if (type == "I" && size == 1) return NumberType::int8;
  if (type == "I" && size == 2) return NumberType::int16;
  if (type == "I" && size == 4) return NumberType::int32;
  if (type == "U" && size == 1) return NumberType::uint8;
  if (type == "U" && size == 2) return NumberType::uint16;
  if (type == "U" && size == 4) return NumberType::uint32;
  throw FileFault("header: a coordinate of type " + text::shown(type) + " and size " + std::to_string(size));
}

std::size_t number_of_points(const Header& header) {
  if (!header.points.empty() && (header.width.empty() || header.height.empty())) {
    return parse_count(header.points, "POINTS");
  }
  const std::size_t width = parse_count(header.width, "WIDTH");
  const std::size_t height = parse_count(header.height, "HEIGHT");
  std::size_t count = 0;
  if (__builtin_mul_overflow(width, height, &count)) throw FileFault("header: WIDTH times HEIGHT is too large");
  if (!header.points.empty() && parse_count(header.points, "POINTS") != count) {
    throw FileFault("header: POINTS " + text::shown(header.points) + " is not WIDTH " + text::shown(header.width) +
                    " times HEIGHT " + text::shown(header.height));
  }
  return count;
}

/// Where fields lie in a record, or, field after field, in all of them.
struct Layout {
  std::array<Column, 3> columns;
  std::array<std::size_t, 3> places{};  // numbers before x, y and z in a line of text
  std::size_t record = 0;               // bytes

  Layout(const Header& header, std::size_t count, bool by_field) {
    constexpr std::size_t kLargest = 1u << 20;
    std::array<bool, 3> there{};
    std::size_t place = 0;
    for (std::size_t f = 0; f < header.fields.size(); ++f) {
      const std::size_t size = parse_count(header.sizes[f], "SIZE");
      const std::size_t repeated = parse_count(header.counts[f], "COUNT");
      if (size > 8 || repeated > kLargest) throw FileFault("header: a field of too large a SIZE or COUNT");
      for (std::size_t c = 0; c < 3; ++c) {
        if (header.fields[f].size() != 1 || header.fields[f][0] != "xyz"[c]) continue;
        if (repeated == 0) throw FileFault("header: COUNT 0 of a coordinate");
        columns[c] = {by_field ? record * count : record, by_field ? size : 0, number_type(header.types[f], size)};
        places[c] = place;
        there[c] = true;
      }
      record += size * repeated;
      place += repeated;
    }
    if (!there[0] || !there[1] || !there[2]) throw FileFault("header: FIELDS without x, y and z");
    if (by_field) return;
    for (Column& column : columns) column.stride = record;
  }
};

std::size_t little_endian_32(std::string_view bytes) {
  std::size_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value |= std::size_t{static_cast<unsigned char>(bytes[k])} << (8 * k);
  return value;
}

Coordinates read_compressed(const Header& header, std::string_view bytes, std::size_t count) {
  if (bytes.size() < 8) throw FileFault("ends before its points begin");
  const std::size_t compressed = little_endian_32(bytes);
  const std::size_t size = little_endian_32(bytes.substr(4));
  if (compressed > bytes.size() - 8) throw FileFault("ends before its compressed points do");
  // Checked against the bytes that are there before the record is multiplied by the count.
  if (count > size) throw FileFault(std::to_string(count) + " points in " + std::to_string(size) + " bytes");
  const Layout layout(header, count, true);
  return read_columns(decompress_lzf(bytes.substr(8, compressed), size), layout.columns, count, false);
}

}  // namespace

std::string decompress_lzf(std::string_view compressed, std::size_t size) {
  // Three bytes give at most 264.
  constexpr std::size_t kLargestRatio = 88;
  if (size / kLargestRatio > compressed.size()) {
    throw FileFault(std::to_string(compressed.size()) + " compressed bytes cannot give " + std::to_string(size));
  }
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&] {
    if (at == compressed.size()) throw FileFault("compressed points end within a run");
    return std::size_t{static_cast<unsigned char>(compressed[at++])};
  };
  while (at < compressed.size()) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > compressed.size() - at) throw FileFault("compressed points end within a run");
      out.append(compressed.substr(at, length));
      at += length;
    } else {
      std::size_t length = control >> 5;
      if (length == 7) length += next();
      length += 2;
      const std::size_t back = ((control & 31) << 8) + next() + 1;
      if (back > out.size()) throw FileFault("compressed points refer to what is before them");
      // Byte by byte: a run may repeat what it writes itself.
      for (std::size_t k = 0; k < length; ++k) out.push_back(out[out.size() - back]);
    }
    if (out.size() > size) break;
  }
  if (out.size() != size) {
    throw FileFault("compressed points give " + std::string(out.size() > size ? "more" : "fewer") + " than " +
                    std::to_string(size) + " bytes");
  }
  return out;
}

Coordinates read_pcd(std::string_view bytes) {
  const Header header = take_header(bytes);
  const std::size_t count = number_of_points(header);
  if (header.data == "binary_compressed") return read_compressed(header, bytes, count);
  if (header.data != "ascii" && header.data != "binary") {
    throw FileFault("header: DATA '" + text::shown(header.data) + "', expected ascii, binary or binary_compressed");
  }
  const Layout layout(header, count, false);
  if (header.data == "binary") {
    require_records(bytes, count, layout.record);
    return read_columns(bytes, layout.columns, count, false);
  }
  Coordinates points = read_number_lines(bytes, layout.places, count, header.lines);
  if (points.size() != count) throw FileFault("ends before its " + std::to_string(count) + " points do");
  return points;
}

}  // namespace consimd::features::detail
