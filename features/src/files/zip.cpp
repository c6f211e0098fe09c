// The directory of a ZIP archive (PKWARE, "APPNOTE.TXT: .ZIP file format specification").
#include "files/zip.hpp"

#define ZLIB_CONST  // input is not written to
#include <zlib.h>

#include <algorithm>
#include <memory>
#include <new>

#include "files/records.hpp"
#include "text/words.hpp"

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

const Bytef* bytes_of(std::string_view bytes) { return reinterpret_cast<const Bytef*>(bytes.data()); }

/// Undoes DEFLATE. Throws FileFault unless exactly `size` bytes come out; memory grows with these only.
std::string inflated(std::string_view deflated, std::size_t size) {
  // Two bits give at most a copy of 258 bytes.
  constexpr std::size_t kLargestRatio = 1032;
  if (size / kLargestRatio > deflated.size()) {
    throw FileFault(std::to_string(deflated.size()) + " compressed bytes cannot give " + std::to_string(size));
  }
  z_stream stream{};
  stream.next_in = bytes_of(deflated);
  stream.avail_in = static_cast<uInt>(deflated.size());
  constexpr int kWithoutHeader = -MAX_WBITS;
  if (inflateInit2(&stream, kWithoutHeader) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> ended(&stream, &inflateEnd);
  // One byte more than promised shows that there are too many.
  const std::size_t most = size + 1;
  constexpr std::size_t kBlock = std::size_t{1} << 16U;
  std::string out;
  int state = Z_OK;
  for (std::size_t given = 0; state == Z_OK && given < most; given = stream.total_out) {
    out.resize(std::min(most, std::max(2 * given, kBlock)));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + given);
    stream.avail_out = static_cast<uInt>(out.size() - given);
    state = inflate(&stream, Z_NO_FLUSH);
  }
  if (state == Z_MEM_ERROR) throw std::bad_alloc();
  if (stream.total_out > size) {
    throw FileFault("compressed data give more than " + std::to_string(size) + " bytes");
  }
  if (state == Z_BUF_ERROR || state == Z_OK) throw FileFault("ends within its compressed data");
  if (state != Z_STREAM_END) {
    throw FileFault(std::string("compressed data are damaged: ") +
                    (stream.msg != nullptr ? stream.msg : "not DEFLATE"));
  }
  if (stream.total_out != size) {
    throw FileFault("compressed data give " + std::to_string(stream.total_out) + " bytes, expected " +
                    std::to_string(size));
  }
  out.resize(size);
  return out;
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
      throw FileFault(text::shown(name) + " of more than 4 GiB, which is not read");
    }
    if ((number(entry, 8, 2) & 1U) != 0) throw FileFault(text::shown(name) + " is encrypted");
    if (method != 0 && method != 8) {
      throw FileFault(text::shown(name) + " is compressed by method " + std::to_string(method) +
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
    std::string contents = entry.deflated ? inflated(entry.packed, entry.size) : std::string(entry.packed);
    if (crc32_z(0, bytes_of(contents), contents.size()) != entry.checksum)
      throw FileFault("its checksum is another one");
    return contents;
  } catch (const FileFault& fault) {
    throw FileFault(text::shown(entry.name) + ": " + fault.what());
  }
}

}  // namespace consimd::features::detail
