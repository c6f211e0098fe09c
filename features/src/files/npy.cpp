// NumPy's form of an array, versions 1 to 3.
#include "files/records.hpp"

namespace consimd::features::detail {
namespace {

/// What follows 'key': in the header's dictionary.
std::string_view value_of(std::string_view header, std::string_view key) {
  std::string quoted(1, '\'');
  quoted.append(key).append(1, '\'');
  const std::size_t at = header.find(quoted);
  const std::size_t colon = at == std::string_view::npos ? at : header.find(':', at);
  if (colon == std::string_view::npos) throw FileFault("header without " + quoted);
  std::string_view value = header.substr(colon + 1);
  while (value.starts_with(' ')) value.remove_prefix(1);
  return value;
}

/// (N, columns)
std::array<std::size_t, 2> shape_of(std::string_view header) {
  std::string_view text = value_of(header, "shape");
  const std::size_t end = text.find(')');
  if (!text.starts_with('(') || end == std::string_view::npos) throw FileFault("header: a shape without brackets");
  text = text.substr(1, end - 1);
  std::vector<std::size_t> sizes;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    std::string_view word = text.substr(0, comma);
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
    while (word.starts_with(' ')) word.remove_prefix(1);
    if (!word.empty()) sizes.push_back(parse_count(word, "a size"));
  }
  if (sizes.size() != 2 || sizes[1] < 3) {
    throw FileFault("an array that is not N x 3: its shape is (" + shown(value_of(header, "shape").substr(1, end - 1)) +
                    ")");
  }
  return {sizes[0], sizes[1]};
}

}  // namespace

Coordinates read_npy(std::string_view bytes) {
  constexpr std::size_t kMagic = 8;  // magic and version
  const auto byte = [&](std::size_t at) { return std::size_t{static_cast<unsigned char>(bytes[at])}; };
  if (!bytes.starts_with("\x93NUMPY")) throw FileFault("not an array as NumPy writes them");
  if (bytes.size() < kMagic + 4) throw FileFault("ends within its header");
  std::size_t length = byte(8) | byte(9) << 8;
  std::size_t begin = kMagic + 2;
  if (byte(6) > 1) {
    length |= byte(10) << 16 | byte(11) << 24;
    begin += 2;
  }
  if (length > bytes.size() - begin) throw FileFault("ends within its header");
  const std::string_view header = bytes.substr(begin, length);
  bytes.remove_prefix(begin + length);

  const std::string_view descr = value_of(header, "descr").substr(0, 5);  // '<f4'
  const bool narrow = descr.find("f4") != std::string_view::npos;
  if (!narrow && descr.find("f8") == std::string_view::npos) {
    throw FileFault("an array of " + shown(descr) + ", expected float32 or float64");
  }
  const auto [count, width] = shape_of(header);
  const NumberType type = narrow ? NumberType::float32 : NumberType::float64;
  const std::size_t size = size_of(type);
  if (width > bytes.size() || count > bytes.size()) {
    throw FileFault("ends before its " + std::to_string(count) + " points do");
  }
  const bool fortran = value_of(header, "fortran_order").starts_with("True");
  std::array<Column, 3> columns;
  for (std::size_t c = 0; c < 3; ++c) {
    columns[c] = fortran ? Column{c * count * size, size, type} : Column{c * size, width * size, type};
  }
  return read_columns(bytes, columns, count, descr.find('>') != std::string_view::npos);
}

}  // namespace consimd::features::detail
