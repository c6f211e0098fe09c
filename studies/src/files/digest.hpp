// Whether something is still what it was.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace consimd::studies {

/// The 64-bit FNV-1a hash of a list of texts. Two lists that differ have different ones but for one chance in 2^64; it
/// is no protection against intent.
class Digest {
 public:
  void add(std::string_view text) noexcept {
    for (const char c : text) add_byte(static_cast<unsigned char>(c));
    // Where a text ends is part of the list.
    for (std::uint64_t size = text.size(), byte = 0; byte < sizeof size; ++byte, size >>= 8U) add_byte(size & 0xffU);
  }

  /// 16 hexadecimal digits.
  [[nodiscard]] std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  void add_byte(std::uint64_t byte) noexcept { hash_ = (hash_ ^ byte) * 0x100000001b3U; }

  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

}  // namespace consimd::studies
