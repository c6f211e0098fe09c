// NumPy's form of an array, versions 1 to 3.
#include "files/records.hpp"
#include "text/words.hpp"

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
  for (std::string_view word : text::split(text, ',')) {
    while (word.starts_with(' ')) word.remove_prefix(1);
    if (!word.empty()) sizes.push_back(parse_count(word, "a size"));
  }
  const auto fault = [&](const std::string& remedy) {
    return FileFault("an array that is not N x 3 or, of matches, N x 6: its shape is (" +
                     text::shown(value_of(header, "shape").substr(1, end - 1)) + ")" + remedy);
  };
  if (sizes.size() != 2 || sizes[1] < 3) throw fault("");
  // Points of x y z, a colour and a normal have nine numbers, and of six points no pose is registered: they lie in
  // columns.
  constexpr std::size_t kFewPoints = 6, kManyColumns = 9;
  if (sizes[0] >= 2 && sizes[0] <= kFewPoints && sizes[1] > kManyColumns) throw fault(": save its transpose");
  return {sizes[0], sizes[1]};
}

/// '<f4', without the quotes, or a list of named fields.
std::string_view type_of(std::string_view header) {
  const std::string_view value = value_of(header, "descr");
  return value.starts_with('\'') ? value.substr(1, value.find('\'', 1) - 1) : value;
}

/// An array of points, and what follows its header.
struct Array {
  std::size_t count = 0;
  std::size_t width = 0;
  NumberType type = NumberType::float64;
  bool swapped = false;
  bool fortran = false;
  std::string_view bytes;

  /// Three columns from `first` on, which the array has.
  [[nodiscard]] Coordinates points(std::size_t first) const {
    const std::size_t size = size_of(type);
    std::array<Column, 3> columns;
    for (std::size_t c = 0; c < 3; ++c) {
      columns[c] =
          fortran ? Column{(first + c) * count * size, size, type} : Column{(first + c) * size, width * size, type};
    }
    return read_columns(bytes, columns, count, swapped);
  }
};

Array read_array(std::string_view bytes) {
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

  const std::string_view descr = type_of(header);
  const bool is_one_type = descr.size() == 3;
  const bool narrow = is_one_type && descr.ends_with("f4");
  if (!narrow && !(is_one_type && descr.ends_with("f8"))) {
    throw FileFault("an array of '" + text::shown(descr) + "', expected float32 or float64" +
                    (descr.starts_with('[') ? ": save one without named fields" : ": save its astype(float)"));
  }
  const auto [count, width] = shape_of(header);
  if (count > 0 && (width > bytes.size() || count > bytes.size())) {
    throw FileFault("ends before its " + std::to_string(count) + " points do");
  }
  return {.count = count,
          .width = width,
          .type = narrow ? NumberType::float32 : NumberType::float64,
          .swapped = descr.starts_with('>'),
          .fortran = value_of(header, "fortran_order").starts_with("True"),
          .bytes = bytes};
}

}  // namespace

Coordinates read_npy(std::string_view bytes) { return read_array(bytes).points(0); }

std::array<Coordinates, 2> read_npy_matches(std::string_view bytes) {
  const Array array = read_array(bytes);
  if (array.width == 6) return {array.points(0), array.points(3)};
  throw FileFault("an array of " + std::to_string(array.width) +
                  " columns: a correspondence has 6, source x y z and target x y z, and a cloud needs the TARGET it is "
                  "registered to");
}

}  // namespace consimd::features::detail
