// The directory of a ZIP archive (PKWARE, "APPNOTE.TXT: .ZIP file format specification").
#include "files/zip.hpp"

#include <array>

#include "files/records.hpp"

namespace consimd::features::detail {
namespace {

std::uint32_t number(std::string_view bytes, std::size_t at, std::size_t width) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < width; ++k) {
    value |= std::uint32_t{static_cast<unsigned char>(bytes[at + k])} << (8 * k);
  }
  return value;
}

/// `size` bytes from `at` on.
std::string_view part(std::string_view bytes, std::size_t at, std::size_t size) {
  if (at > bytes.size() || size > bytes.size() - at) throw FileFault("a ZIP archive that ends early");
  return bytes.substr(at, size);
}

/// CRC-32 (section 4.4.7): the remainder by the polynomial 0xedb88320, lowest bit first.
std::uint32_t checksum_of(std::string_view bytes) {
  static constexpr std::array<std::uint32_t, 256> kRemainders = [] {
    std::array<std::uint32_t, 256> remainders{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
      remainders[byte] = byte;
      for (int bit = 0; bit < 8; ++bit) {
        remainders[byte] = (remainders[byte] >> 1U) ^ ((remainders[byte] & 1U) != 0 ? 0xedb88320U : 0U);
      }
    }
    return remainders;
  }();
  std::uint32_t remainder = 0xffffffffU;
  for (const char c : bytes) {
    remainder = kRemainders[(remainder ^ static_cast<unsigned char>(c)) & 0xffU] ^ (remainder >> 8U);
  }
  return ~remainder;
}

}  // namespace

std::vector<ZipEntry> zip_entries(std::string_view bytes) {
  constexpr std::size_t kEndSize = 22;
  constexpr std::size_t kEntrySize = 46;
  constexpr std::size_t kLocalSize = 30;
  constexpr std::uint32_t kLarge = 0xffffffffU;  // the number is in a field of ZIP64
  const std::size_t end = bytes.rfind("PK\5\6");
  if (end == std::string_view::npos) throw FileFault("a ZIP archive without a directory: is the file whole?");
  const std::string_view last = part(bytes, end, kEndSize);
  const std::uint32_t count = number(last, 10, 2);
  std::size_t at = number(last, 16, 4);
  if (at == kLarge || count == 0xffff) throw FileFault("a ZIP archive of more than 4 GiB, which is not read");
  std::vector<ZipEntry> entries;
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::string_view entry = part(bytes, at, kEntrySize);
    if (!entry.starts_with("PK\1\2")) throw FileFault("a ZIP archive with a damaged directory");
    const std::size_t name_length = number(entry, 28, 2);
    const std::string_view name = part(bytes, at + kEntrySize, name_length);
    const std::uint32_t method = number(entry, 10, 2);
    const std::uint32_t packed = number(entry, 20, 4);
    const std::uint32_t size = number(entry, 24, 4);
    const std::uint32_t offset = number(entry, 42, 4);
    if (packed == kLarge || size == kLarge || offset == kLarge) {
      throw FileFault(shown(name) + " of more than 4 GiB, which is not read");
    }
    if ((number(entry, 8, 2) & 1U) != 0) throw FileFault(shown(name) + " is encrypted");
    if (method != 0 && method != 8) {
      throw FileFault(shown(name) + " is compressed by method " + std::to_string(method) +
                      ", expected stored or deflated");
    }
    if (method == 0 && packed != size) throw FileFault("a ZIP archive with a damaged directory");
    const std::string_view local = part(bytes, offset, kLocalSize);
    if (!local.starts_with("PK\3\4")) throw FileFault("a ZIP archive with a damaged directory");
    const std::size_t begin = std::size_t{offset} + kLocalSize + number(local, 26, 2) + number(local, 28, 2);
    entries.push_back({name, part(bytes, begin, packed), method == 8, size, number(entry, 16, 4)});
    at += kEntrySize + name_length + number(entry, 30, 2) + number(entry, 32, 2);
  }
  return entries;
}

std::string unpacked(const ZipEntry& entry) {
  try {
    std::string contents = entry.deflated ? inflate(entry.packed, entry.size) : std::string(entry.packed);
    if (checksum_of(contents) != entry.checksum) throw FileFault("its checksum is another one");
    return contents;
  } catch (const FileFault& fault) {
    throw FileFault(shown(entry.name) + ": " + fault.what());
  }
}

}  // namespace consimd::features::detail
