// DEFLATE, as RFC 1951 has it.
#include <algorithm>
#include <array>
#include <span>

#include "files/records.hpp"
#include "files/zip.hpp"

namespace consimd::features::detail {
namespace {

constexpr unsigned kLongestCode = 15;

[[noreturn]] void fail_damaged() { throw FileFault("compressed data are damaged"); }

/// The lowest bit of each byte first.
class Bits {
 public:
  explicit Bits(std::string_view bytes) : bytes_(bytes) {}

  /// The next bits without taking them, zeros beyond the end. count <= 16.
  std::uint32_t peek(unsigned count) {
    while (held_ < count) {
      const std::uint64_t byte = at_ < bytes_.size() ? static_cast<unsigned char>(bytes_[at_]) : 0u;
      ++at_;
      bits_ |= byte << held_;
      held_ += 8;
    }
    return static_cast<std::uint32_t>(bits_ & ((std::uint64_t{1} << count) - 1));
  }

  void skip(unsigned count) {
    bits_ >>= count;
    held_ -= count;
    // Bits beyond the end may be looked at, but not taken.
    if (at_ > bytes_.size() + held_ / 8) throw FileFault("ends within its compressed data");
  }

  std::uint32_t take(unsigned count) {
    const std::uint32_t value = peek(count);
    skip(count);
    return value;
  }

  /// Takes whole bytes after the rest of the one begun.
  std::string_view take_bytes(std::size_t count) {
    skip(held_ % 8);
    at_ -= held_ / 8;
    bits_ = held_ = 0;
    if (count > bytes_.size() - at_) throw FileFault("ends within its compressed data");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  std::uint64_t bits_ = 0;
  unsigned held_ = 0;
};

/// A canonical prefix code (section 3.2.2), in a table of what each sequence of bits begins with.
class PrefixCode {
 public:
  explicit PrefixCode(std::span<const std::uint8_t> lengths) {
    std::array<std::uint32_t, kLongestCode + 2> next{};
    for (const std::uint8_t length : lengths) {
      if (length > 0) ++next[length + 1u];
      longest_ = std::max<unsigned>(longest_, length);
    }
    for (unsigned length = 1; length <= kLongestCode; ++length) {
      next[length + 1] += 2 * next[length];
      // What the codes of up to this length use up, in units of its last bit.
      if (next[length + 1] > 1u << length) fail_damaged();
    }
    table_.assign(std::size_t{1} << longest_, Entry{});
    std::array<std::uint32_t, kLongestCode + 1> code{};
    for (unsigned length = 1; length <= kLongestCode; ++length) code[length] = 2 * next[length];
    for (std::size_t symbol = 0; symbol < lengths.size(); ++symbol) {
      const unsigned length = lengths[symbol];
      if (length == 0) continue;
      std::uint32_t reversed = 0;
      for (unsigned bit = 0; bit < length; ++bit) reversed |= (code[length] >> bit & 1u) << (length - 1 - bit);
      ++code[length];
      for (std::size_t k = reversed; k < table_.size(); k += std::size_t{1} << length) {
        table_[k] = {static_cast<std::uint16_t>(symbol), static_cast<std::uint8_t>(length)};
      }
    }
  }

  std::size_t symbol(Bits& bits) const {
    const Entry& entry = table_[bits.peek(longest_)];
    if (entry.length == 0) fail_damaged();
    bits.skip(entry.length);
    return entry.symbol;
  }

 private:
  struct Entry {
    std::uint16_t symbol = 0;
    std::uint8_t length = 0;
  };

  std::vector<Entry> table_;
  unsigned longest_ = 0;
};

/// What a symbol stands for: the least value and the bits that are added to it.
struct Range {
  std::uint32_t least;
  unsigned extra;
};

constexpr std::size_t kEnd = 256;  // of a block; symbols below are bytes, those above are lengths

/// Section 3.2.5, the lengths of copies: eight alone, then four of each number of extra bits; the last is 258.
constexpr std::array<Range, 29> kLengths = [] {
  std::array<Range, 29> ranges{};
  std::uint32_t least = 3;
  for (unsigned k = 0; k < 28; ++k) {
    ranges[k] = {least, k < 8 ? 0 : k / 4 - 1};
    least += 1u << ranges[k].extra;
  }
  ranges[28] = {258, 0};
  return ranges;
}();

/// The same, their distances: four alone, then two of each number of extra bits.
constexpr std::array<Range, 30> kDistances = [] {
  std::array<Range, 30> ranges{};
  std::uint32_t least = 1;
  for (unsigned k = 0; k < 30; ++k) {
    ranges[k] = {least, k < 4 ? 0 : k / 2 - 1};
    least += 1u << ranges[k].extra;
  }
  return ranges;
}();

template <std::size_t N>
std::size_t value_of(std::size_t symbol, const std::array<Range, N>& ranges, Bits& bits) {
  if (symbol >= N) fail_damaged();
  return std::size_t{ranges[symbol].least} + bits.take(ranges[symbol].extra);
}

struct BlockCodes {
  PrefixCode literals;
  PrefixCode distances;
};

/// Section 3.2.6.
BlockCodes fixed_codes() {
  std::array<std::uint8_t, 288> lengths{};
  for (std::size_t k = 0; k < lengths.size(); ++k) {
    lengths[k] = k < 144 ? std::uint8_t{8} : k < 256 ? std::uint8_t{9} : k < 280 ? std::uint8_t{7} : std::uint8_t{8};
  }
  std::array<std::uint8_t, 32> distances{};
  distances.fill(5);
  return {PrefixCode(lengths), PrefixCode(distances)};
}

/// Section 3.2.7.
BlockCodes dynamic_codes(Bits& bits) {
  const std::size_t literals = 257 + bits.take(5);
  const std::size_t distances = 1 + bits.take(5);
  const std::size_t given = 4 + bits.take(4);
  constexpr std::array<std::uint8_t, 19> kOrder{16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
  std::array<std::uint8_t, 19> of_lengths{};
  for (std::size_t k = 0; k < given; ++k) of_lengths[kOrder[k]] = static_cast<std::uint8_t>(bits.take(3));
  const PrefixCode code(of_lengths);
  std::vector<std::uint8_t> lengths;
  while (lengths.size() < literals + distances) {
    const std::size_t symbol = code.symbol(bits);
    if (symbol < 16) {
      lengths.push_back(static_cast<std::uint8_t>(symbol));
      continue;
    }
    if (symbol == 16 && lengths.empty()) fail_damaged();
    const std::uint8_t repeated = symbol == 16 ? lengths.back() : std::uint8_t{0};
    const std::size_t times = symbol == 16 ? 3 + bits.take(2) : symbol == 17 ? 3 + bits.take(3) : 11 + bits.take(7);
    lengths.insert(lengths.end(), times, repeated);
  }
  if (lengths.size() > literals + distances) fail_damaged();
  const std::span<const std::uint8_t> all(lengths);
  return {PrefixCode(all.first(literals)), PrefixCode(all.subspan(literals))};
}

}  // namespace

std::string inflate(std::string_view deflated, std::size_t size) {
  // Two bits give at most a copy of 258 bytes.
  constexpr std::size_t kLargestRatio = 1032;
  if (size / kLargestRatio > deflated.size()) {
    throw FileFault(std::to_string(deflated.size()) + " compressed bytes cannot give " + std::to_string(size));
  }
  std::string out;
  const auto require_room = [&](std::size_t count) {
    if (count > size - out.size()) {
      throw FileFault("compressed data give more than " + std::to_string(size) + " bytes");
    }
  };
  Bits bits(deflated);
  for (bool last = false; !last;) {
    last = bits.take(1) != 0;
    const std::uint32_t kind = bits.take(2);
    if (kind == 3) fail_damaged();
    if (kind == 0) {
      const auto byte = [](std::string_view of, std::size_t k) { return unsigned{static_cast<unsigned char>(of[k])}; };
      const std::string_view header = bits.take_bytes(4);
      const unsigned count = byte(header, 0) | byte(header, 1) << 8;
      if ((count ^ (byte(header, 2) | byte(header, 3) << 8)) != 0xffff) fail_damaged();
      require_room(count);
      out.append(bits.take_bytes(count));
      continue;
    }
    const BlockCodes codes = kind == 1 ? fixed_codes() : dynamic_codes(bits);
    for (std::size_t symbol = codes.literals.symbol(bits); symbol != kEnd; symbol = codes.literals.symbol(bits)) {
      if (symbol < kEnd) {
        require_room(1);
        out.push_back(static_cast<char>(static_cast<unsigned char>(symbol)));
        continue;
      }
      const std::size_t length = value_of(symbol - kEnd - 1, kLengths, bits);
      const std::size_t distance = value_of(codes.distances.symbol(bits), kDistances, bits);
      if (distance > out.size()) fail_damaged();
      require_room(length);
      // Byte by byte: a copy may repeat what it writes itself.
      for (std::size_t k = 0; k < length; ++k) out.push_back(out[out.size() - distance]);
    }
  }
  if (out.size() != size) {
    throw FileFault("compressed data give " + std::to_string(out.size()) + " bytes, expected " + std::to_string(size));
  }
  return out;
}

}  // namespace consimd::features::detail
