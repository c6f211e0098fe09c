#include <consimd/kernels/descriptor_matches.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

#include "../dispatch.hpp"
#include "../kernel_arguments.hpp"

namespace consimd {
namespace {

constexpr std::align_val_t kAlignment{64};
constexpr std::size_t kTileSize = 16;
constexpr std::size_t kLongest = 4096;
// The square of twice this is below 2^31, so that no squared distance overflows.
constexpr double kLargestNorm = 23170.0;

std::size_t padded(std::size_t size) { return (size + kTileSize - 1) / kTileSize * kTileSize; }

void require_length(std::size_t length) {
  if (length >= 1 && length <= kLongest) return;
  throw std::invalid_argument("descriptors of length " + std::to_string(length) + ", expected 1 to " +
                              std::to_string(kLongest));
}

/// Parts of the one array of a FixedPointDescriptors, in its order: squared norms (each the place of two components),
/// tiles, rows.
struct Parts {
  std::size_t tiles;
  std::size_t rows;
  std::size_t end;

  Parts(std::size_t size, std::size_t pairs)
      : tiles(2 * padded(size)), rows(tiles + 2 * pairs * padded(size)), end(rows + 2 * pairs * padded(size)) {}
};

}  // namespace

void FixedPointDescriptors::AlignedDelete::operator()(std::int16_t* p) const noexcept {
  ::operator delete[](p, kAlignment);
}

double FixedPointDescriptors::unit_for(double largest_norm, std::size_t length) {
  require_length(length);
  if (!std::isfinite(largest_norm) || largest_norm < 0.0) {
    throw std::invalid_argument("largest_norm is " + std::to_string(largest_norm) + ", expected a finite number >= 0");
  }
  if (largest_norm == 0.0) return 1.0;
  // Rounding may lengthen a descriptor by half a unit a component.
  return std::max(largest_norm / (kLargestNorm - 1.0 - std::sqrt(static_cast<double>(length)) / 2.0),
                  std::numeric_limits<double>::min());
}

FixedPointDescriptors::FixedPointDescriptors(std::span<const float> values, std::size_t length, double unit)
    : size_(length == 0 ? 0 : values.size() / length), length_(length), pairs_((length + 1) / 2), unit_(unit) {
  require_length(length);
  detail::require_size("values", values.size(), size_ * length);
  if (!std::isfinite(unit) || unit <= 0.0) {
    throw std::invalid_argument("unit is " + std::to_string(unit) + ", expected a finite number above 0");
  }
  const Parts parts(size_, pairs_);
  data_.reset(static_cast<std::int16_t*>(::operator new[](parts.end * sizeof(std::int16_t), kAlignment)));
  std::fill_n(data_.get(), parts.end, std::int16_t{0});
  auto* squared_norms = reinterpret_cast<std::int32_t*>(data_.get());
  for (std::size_t i = 0; i < size_; ++i) {
    std::int16_t* row = data_.get() + parts.rows + 2 * pairs_ * i;
    double squared = 0.0;
    for (std::size_t c = 0; c < length; ++c) {
      const double value = std::nearbyint(static_cast<double>(values[i * length + c]) / unit);
      if (!(std::abs(value) <= kLargestNorm)) {
        throw std::invalid_argument("descriptor " + std::to_string(i) + ": component " + std::to_string(c) + " is " +
                                    std::to_string(values[i * length + c]) + ", expected a number within " +
                                    std::to_string(kLargestNorm * unit));
      }
      row[c] = static_cast<std::int16_t>(value);
      squared += value * value;
    }
    if (squared > kLargestNorm * kLargestNorm) {
      throw std::invalid_argument("descriptor " + std::to_string(i) + " has norm " +
                                  std::to_string(std::sqrt(squared) * unit) + ", expected at most " +
                                  std::to_string(kLargestNorm * unit));
    }
    squared_norms[i] = static_cast<std::int32_t>(squared);
    std::int16_t* tile = data_.get() + parts.tiles + 2 * pairs_ * (i / kTileSize * kTileSize) + 2 * (i % kTileSize);
    for (std::size_t c = 0; c < pairs_; ++c) std::copy_n(row + 2 * c, 2, tile + 2 * kTileSize * c);
  }
}

void BestMatches::AlignedDelete::operator()(std::int32_t* p) const noexcept { ::operator delete[](p, kAlignment); }

BestMatches::BestMatches(std::size_t size, std::size_t k) : size_(size), k_(k), stride_(padded(size)) {
  if (k < 1 || k > detail::kMostMatches) {
    throw std::invalid_argument("k is " + std::to_string(k) + ", expected 1 to " +
                                std::to_string(detail::kMostMatches));
  }
  data_.reset(static_cast<std::int32_t*>(::operator new[](2 * k_ * stride_ * sizeof(std::int32_t), kAlignment)));
  std::fill_n(data_.get(), k_ * stride_, std::numeric_limits<std::int32_t>::max());
  std::fill_n(reinterpret_cast<std::uint32_t*>(data_.get() + k_ * stride_), k_ * stride_, kNone);
}

void BestMatches::merge(const BestMatches& other) {
  detail::require_size("other", other.size_, size_);
  detail::require_size("a list of other", other.k_, k_);
  std::int32_t* mine = data_.get();
  auto* my_indices = reinterpret_cast<std::uint32_t*>(data_.get() + k_ * stride_);
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t from = 0; from < k_; ++from) {
      const std::int32_t distance = other.squared_distance(i, from);
      const std::uint32_t index = other.index(i, from);
      const auto comes_first = [&](std::size_t rank) {
        const std::size_t at = rank * stride_ + i;
        return distance < mine[at] || (distance == mine[at] && index < my_indices[at]);
      };
      std::size_t rank = k_ - 1;
      if (!comes_first(rank)) break;
      for (; rank > 0 && comes_first(rank - 1); --rank) {
        mine[rank * stride_ + i] = mine[(rank - 1) * stride_ + i];
        my_indices[rank * stride_ + i] = my_indices[(rank - 1) * stride_ + i];
      }
      mine[rank * stride_ + i] = distance;
      my_indices[rank * stride_ + i] = index;
    }
  }
}

void best_matches(const FixedPointDescriptors& queries, std::size_t first, std::size_t last,
                  const FixedPointDescriptors& targets, BestMatches& of_queries, BestMatches& of_targets) {
  if (queries.length_ != targets.length_ || queries.unit_ != targets.unit_) {
    throw std::invalid_argument("descriptors of length " + std::to_string(queries.length_) + " and unit " +
                                std::to_string(queries.unit_) + " against length " + std::to_string(targets.length_) +
                                " and unit " + std::to_string(targets.unit_));
  }
  detail::require_size("of_queries", of_queries.size_, queries.size_);
  detail::require_size("of_targets", of_targets.size_, targets.size_);
  detail::require_size("a list of of_targets", of_targets.k_, of_queries.k_);
  if (first > last || last > queries.size_) {
    throw std::out_of_range("queries from " + std::to_string(first) + " to " + std::to_string(last) + " of " +
                            std::to_string(queries.size_));
  }
  const auto raw = [](const FixedPointDescriptors& d) {
    const Parts parts(d.size_, d.pairs_);
    const std::int16_t* data = d.data_.get();
    return detail::RawDescriptors{data + parts.rows, data + parts.tiles, reinterpret_cast<const std::int32_t*>(data),
                                  d.size_, d.pairs_};
  };
  const auto raw_matches = [](BestMatches& m) {
    return detail::RawMatches{m.data_.get(), reinterpret_cast<std::uint32_t*>(m.data_.get() + m.k_ * m.stride_),
                              m.stride_};
  };
  detail::active_table().clouds.best_matches(raw(queries), first, last, raw(targets), of_queries.k_,
                                             raw_matches(of_queries), raw_matches(of_targets));
}

}  // namespace consimd
