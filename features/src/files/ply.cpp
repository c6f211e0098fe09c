// The PLY form (Turk, "The PLY polygon file format").
#include "files/records.hpp"
#include "text/words.hpp"

namespace consimd::features::detail {
namespace {

struct Property {
  std::string_view name;
  NumberType type;
};

struct Element {
  std::string_view name;
  std::size_t count = 0;
  std::vector<Property> properties;
  bool has_list = false;

  [[nodiscard]] std::size_t size() const {
    std::size_t bytes = 0;
    for (const Property& property : properties) bytes += size_of(property.type);
    return bytes;
  }
};

NumberType number_type(std::string_view name) {
  if (name == "char" || name == "int8") return NumberType::int8;
  if (name == "uchar" || name == "uint8") return NumberType::uint8;
  if (name == "short" || name == "int16") return NumberType::int16;
  if (name == "ushort" || name == "uint16") return NumberType::uint16;
  if (name == "int" || name == "int32") return NumberType::int32;
  if (name == "uint" || name == "uint32") return NumberType::uint32;
  if (name == "float" || name == "float32") return NumberType::float32;
  if (name == "double" || name == "float64") return NumberType::float64;
  throw FileFault("header: a property of type '" + text::shown(name) + "'");
}

struct Header {
  std::string_view format;
  std::vector<Element> elements;
  std::size_t lines = 0;
};

/// Takes the header off the bytes.
Header take_header(std::string_view& bytes) {
  Header header;
  while (true) {
    if (bytes.empty()) throw FileFault("header without end_header");
    const std::vector<std::string_view> words = words_between_blanks(text::take_line(bytes));
    ++header.lines;
    if (words.empty()) continue;
    if (words[0] == "end_header") return header;
    if (words[0] == "format" && words.size() >= 2) {
      header.format = words[1];
    } else if (words[0] == "element" && words.size() == 3) {
      header.elements.push_back({words[1], parse_count(words[2], "the number of elements"), {}});
    } else if (words[0] == "property" && words.size() >= 3 && !header.elements.empty()) {
      Element& element = header.elements.back();
      if (words[1] == "list") {
        element.has_list = true;
      } else {
        element.properties.push_back({words[2], number_type(words[1])});
      }
    }
  }
}

}  // namespace

Coordinates read_ply(std::string_view bytes) {
  const Header header = take_header(bytes);
  const bool ascii = header.format == "ascii";
  const bool little = header.format == "binary_little_endian";
  if (!ascii && !little && header.format != "binary_big_endian") {
    throw FileFault("header: format '" + text::shown(header.format) +
                    "', expected ascii, binary_little_endian or binary_big_endian");
  }
  std::size_t before = 0;  // bytes of the elements before the vertices, or lines
  for (const Element& element : header.elements) {
    if (element.name != "vertex") {
      if (element.has_list && !ascii && element.count > 0) {
        throw FileFault("lists before the vertices: write the vertices first");
      }
      const std::size_t size = ascii ? 1 : element.size();
      if (size > 0 && element.count > bytes.size() / size) throw FileFault("ends before its vertices begin");
      before += element.count * size;
      if (before > bytes.size()) throw FileFault("ends before its vertices begin");
      continue;
    }
    if (element.has_list) throw FileFault("vertices with a list: write them without");
    std::array<Column, 3> columns;
    std::array<std::size_t, 3> places{};
    std::array<bool, 3> there{};
    std::size_t offset = before;
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      const Property& property = element.properties[k];
      for (std::size_t c = 0; c < 3; ++c) {
        if (property.name.size() != 1 || (property.name[0] | 0x20) != "xyz"[c]) continue;
        columns[c] = {offset, element.size(), property.type};
        places[c] = k;
        there[c] = true;
      }
      offset += size_of(property.type);
    }
    if (!there[0] || !there[1] || !there[2]) throw FileFault("header: vertices without x, y and z");
    if (!ascii) {
      require_records(bytes.substr(before), element.count, element.size());
      return read_columns(bytes, columns, element.count, !little);
    }
    for (std::size_t line = 0; line < before; ++line) static_cast<void>(text::take_line(bytes));
    Coordinates points = read_number_lines(bytes, places, element.count, header.lines + before);
    if (points.size() != element.count) {
      throw FileFault("ends before its " + std::to_string(element.count) + " points do");
    }
    return points;
  }
  throw FileFault("header: no vertices");
}

}  // namespace consimd::features::detail
