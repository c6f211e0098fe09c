#include <consimd/kernels/descriptor_matches.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <numeric>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "../dispatch.hpp"
#include "../kernel_arguments.hpp"
#include "descriptor_order.hpp"

namespace consimd {
namespace {

using detail::kBoxed;
using detail::kLeadingPairs;
using detail::kTileSize;

constexpr std::align_val_t kAlignment{64};
constexpr std::size_t kLongest = 4096;
// The square of twice this is below 2^31, so that no squared distance overflows.
constexpr double kLargestNorm = 23170.0;

std::size_t padded(std::size_t size) { return (size + kTileSize - 1) / kTileSize * kTileSize; }

std::int32_t* allocate(std::size_t size) {
  return static_cast<std::int32_t*>(::operator new[](size * sizeof(std::int32_t), kAlignment));
}

/// Where in the one array of a FixedPointDescriptors each part begins; a pair of components takes a place.
struct Parts {
  std::size_t leading_norms, numbers, lows, highs, tiles, rows, end;
  std::size_t box_stride;

  Parts(std::size_t size, std::size_t pairs)
      : leading_norms(padded(size)),
        numbers(2 * padded(size)),
        lows(3 * padded(size)),
        highs(lows + kBoxed * padded(padded(size) / kTileSize)),
        tiles(highs + (highs - lows)),
        rows(tiles + pairs * padded(size)),
        end(rows + pairs * padded(size)),
        box_stride((highs - lows) / kBoxed) {}
};

/// Sums of one component of all descriptors.
struct Spread {
  double sum = 0.0;
  double squared = 0.0;

  [[nodiscard]] double of(double count) const { return squared - sum * sum / count; }
};

/// Adds a set's components to the spreads; returns its largest squared norm. `set`: its name, for errors.
double add_spreads(std::string_view set, std::span<const float> values, std::span<Spread> spreads) {
  const std::size_t length = spreads.size();
  double largest = 0.0;
  for (std::size_t i = 0; i < values.size(); i += length) {
    double squared = 0.0;
    for (std::size_t c = 0; c < length; ++c) {
      const auto value = static_cast<double>(values[i + c]);
      spreads[c].sum += value;
      spreads[c].squared += value * value;
      squared += value * value;
    }
    if (!std::isfinite(squared)) {
      throw std::invalid_argument(std::string(set) + ": descriptor " + std::to_string(i / length) + " is not finite");
    }
    largest = std::max(largest, squared);
  }
  return largest;
}

/// To the nearest whole number, the even one of two, where |x| is below 2^51: the sum has no room for less.
double rounded(double x) { return (x + 0x1.8p52) - 0x1.8p52; }

[[noreturn]] void refuse(std::span<const float> descriptor, std::size_t i, const FixedPointForm& form) {
  const std::string limit = std::to_string(kLargestNorm * form.unit());
  for (std::size_t c = 0; c < descriptor.size(); ++c) {
    if (std::abs(static_cast<double>(descriptor[c])) <= kLargestNorm * form.unit()) continue;
    throw std::invalid_argument("descriptor " + std::to_string(i) + ": component " + std::to_string(c) + " is " +
                                std::to_string(descriptor[c]) + ", expected a number within " + limit);
  }
  throw std::invalid_argument("descriptor " + std::to_string(i) + " is longer than " + limit);
}

/// Descriptors in units, their components in the form's order, in rows of `stride` numbers that are filled up with 0.
std::vector<std::int16_t> whole_numbers(std::span<const float> values, const FixedPointForm& form, std::size_t stride) {
  const std::size_t length = form.length();
  std::vector<std::int16_t> whole(values.size() / length * stride);
  std::vector<double> row(length);
  for (std::size_t i = 0; i < values.size() / length; ++i) {
    const std::span<const float> descriptor = values.subspan(i * length, length);
    for (std::size_t c = 0; c < length; ++c) row[c] = static_cast<double>(descriptor[form.components()[c]]);
    for (double& x : row) x = rounded(x / form.unit());
    double squared = 0.0;
    for (const double x : row) squared += x * x;
    if (!(squared <= kLargestNorm * kLargestNorm)) refuse(descriptor, i, form);
    for (std::size_t c = 0; c < length; ++c) whole[i * stride + c] = static_cast<std::int16_t>(row[c]);
  }
  return whole;
}

}  // namespace

FixedPointForm::FixedPointForm(std::span<const float> source, std::span<const float> target, std::size_t length) {
  if (length < 1 || length > kLongest) {
    throw std::invalid_argument("descriptors of length " + std::to_string(length) + ", expected 1 to " +
                                std::to_string(kLongest));
  }
  detail::require_size("source", source.size(), source.size() / length * length);
  detail::require_size("target", target.size(), target.size() / length * length);
  std::vector<Spread> spreads(length);
  const double largest =
      std::sqrt(std::max(add_spreads("source", source, spreads), add_spreads("target", target, spreads)));
  // Rounding may lengthen a descriptor by half a unit a component.
  const double most = kLargestNorm - 1.0 - std::sqrt(static_cast<double>(length)) / 2.0;
  if (largest > 0.0) unit_ = largest / most;

  const double count = static_cast<double>(source.size() + target.size()) / static_cast<double>(length);
  components_.resize(length);
  std::iota(components_.begin(), components_.end(), std::uint16_t{0});
  std::stable_sort(components_.begin(), components_.end(),
                   [&](std::uint16_t a, std::uint16_t b) { return spreads[a].of(count) > spreads[b].of(count); });
}

void FixedPointDescriptors::AlignedDelete::operator()(std::int32_t* p) const noexcept {
  ::operator delete[](p, kAlignment);
}

FixedPointDescriptors::FixedPointDescriptors(std::span<const float> values, const FixedPointForm& form) : form_(form) {
  const std::size_t size = values.size() / form.length();
  detail::require_size("values", values.size(), size * form.length());
  if (size > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw std::invalid_argument(std::to_string(size) + " descriptors, expected fewer than 2^31");
  }
  const std::size_t pairs = (form.length() + 1) / 2;
  const std::vector<std::int16_t> whole = whole_numbers(values, form, 2 * pairs);
  const std::vector<std::uint32_t> order = detail::alike_together(whole, 2 * pairs, 2 * kLeadingPairs, kTileSize);
  places_.resize(size);
  for (std::size_t place = 0; place < size; ++place) places_[order[place]] = static_cast<std::uint32_t>(place);

  const Parts parts(size, pairs);
  data_.reset(allocate(parts.end));
  std::int32_t* data = data_.get();
  std::memset(data, 0, parts.end * sizeof(std::int32_t));
  // Behind the last tile are boxes that hold all descriptors, so that gaps are small, with centres that are farther
  // from any than descriptors are from each other.
  std::fill(data + parts.lows, data + parts.highs, -static_cast<std::int32_t>(kLargestNorm));
  std::fill(data + parts.highs, data + parts.tiles, 8 * static_cast<std::int32_t>(kLargestNorm));
  auto* const rows = reinterpret_cast<std::int16_t*>(data + parts.rows);
  auto* const tiles = reinterpret_cast<std::int16_t*>(data + parts.tiles);
  for (std::size_t place = 0; place < size; ++place) {
    const std::int16_t* row = whole.data() + 2 * pairs * order[place];
    const std::size_t tile = place / kTileSize;
    const std::size_t in_tile = place % kTileSize;
    const std::size_t leading = std::min(2 * pairs, 2 * kLeadingPairs);
    data[parts.leading_norms + place] = std::inner_product(row, row + leading, row, 0);
    data[place] = std::inner_product(row, row + 2 * pairs, row, 0);
    data[parts.numbers + place] = static_cast<std::int32_t>(order[place]);
    std::copy_n(row, 2 * pairs, rows + 2 * pairs * place);
    for (std::size_t c = 0; c < pairs; ++c) {
      std::copy_n(row + 2 * c, 2, tiles + 2 * (kTileSize * (tile * pairs + c) + in_tile));
    }
    for (std::size_t c = 0; c < kBoxed; ++c) {
      const std::int32_t component = c < 2 * pairs ? row[c] : 0;
      std::int32_t& low = data[parts.lows + c * parts.box_stride + tile];
      std::int32_t& high = data[parts.highs + c * parts.box_stride + tile];
      low = in_tile == 0 ? component : std::min(low, component);
      high = in_tile == 0 ? component : std::max(high, component);
    }
  }
}

BestMatches::BestMatches(const FixedPointDescriptors& of, std::size_t k)
    : places_(of.places_), k_(k), stride_(padded(of.size())) {
  if (k < 1 || k > detail::kMostMatches) {
    throw std::invalid_argument("k is " + std::to_string(k) + ", expected 1 to " +
                                std::to_string(detail::kMostMatches));
  }
  data_.reset(allocate(2 * k_ * stride_));
  for (std::size_t rank = 0; rank < k_; ++rank) {
    std::int32_t* distances = data_.get() + rank * stride_;
    std::fill_n(distances, size(), std::numeric_limits<std::int32_t>::max());
    std::fill(distances + size(), distances + stride_, -1);
  }
  std::fill_n(data_.get() + k_ * stride_, k_ * stride_, static_cast<std::int32_t>(kNone));
}

void BestMatches::merge(const BestMatches& other) {
  detail::require_size("a list of other", other.k_, k_);
  if (other.places_ != places_) throw std::invalid_argument("other are lists of other descriptors");
  using Key = std::pair<std::int32_t, std::uint32_t>;
  const auto key = [](const BestMatches& list, std::size_t at) { return Key(list.data_[at], list.numbers()[at]); };
  std::vector<Key> both(2 * k_);
  for (std::size_t place = 0; place < size(); ++place) {
    for (std::size_t rank = 0; rank < k_; ++rank) {
      both[rank] = key(*this, rank * stride_ + place);
      both[k_ + rank] = key(other, rank * stride_ + place);
    }
    std::inplace_merge(both.begin(), both.begin() + static_cast<std::ptrdiff_t>(k_), both.end());
    for (std::size_t rank = 0; rank < k_; ++rank) {
      data_[rank * stride_ + place] = both[rank].first;
      data_[(k_ + rank) * stride_ + place] = static_cast<std::int32_t>(both[rank].second);
    }
  }
}

void best_matches(const FixedPointDescriptors& queries, const FixedPointDescriptors& targets, BestMatches& of_queries,
                  BestMatches& of_targets, std::size_t part, std::size_t parts) {
  if (queries.form_ != targets.form_) {
    throw std::invalid_argument("descriptors of length " + std::to_string(queries.form_.length()) + " and unit " +
                                std::to_string(queries.form_.unit()) + " against length " +
                                std::to_string(targets.form_.length()) + " and unit " +
                                std::to_string(targets.form_.unit()) + " or another order of components");
  }
  if (of_queries.places_ != queries.places_) throw std::invalid_argument("of_queries are lists of other descriptors");
  if (of_targets.places_ != targets.places_) throw std::invalid_argument("of_targets are lists of other descriptors");
  detail::require_size("a list of of_targets", of_targets.k_, of_queries.k_);
  if (part >= parts) {
    throw std::out_of_range("part " + std::to_string(part) + " of " + std::to_string(parts));
  }
  const auto raw = [](const FixedPointDescriptors& d) {
    const std::size_t pairs = (d.form_.length() + 1) / 2;
    const Parts at(d.size(), pairs);
    const std::int32_t* data = d.data_.get();
    return detail::RawDescriptors{.rows = reinterpret_cast<const std::int16_t*>(data + at.rows),
                                  .tiles = reinterpret_cast<const std::int16_t*>(data + at.tiles),
                                  .squared_norms = data,
                                  .leading_norms = data + at.leading_norms,
                                  .numbers = data + at.numbers,
                                  .lows = data + at.lows,
                                  .highs = data + at.highs,
                                  .box_stride = at.box_stride,
                                  .size = d.size(),
                                  .pairs = pairs};
  };
  const auto raw_matches = [](BestMatches& m) {
    return detail::RawMatches{m.data_.get(), m.data_.get() + m.k_ * m.stride_, m.stride_};
  };
  // Every parts-th group, so that each part has some of all descriptors.
  const std::size_t all = (queries.size() + detail::kQueryGroup - 1) / detail::kQueryGroup;
  const std::size_t groups = all > part ? (all - part + parts - 1) / parts : 0;
  const std::size_t tiles = padded(padded(targets.size()) / kTileSize);
  const std::unique_ptr<std::int32_t[], FixedPointDescriptors::AlignedDelete> numbers(
      allocate(2 * tiles + (2 * kBoxed + 1) * groups));
  std::int32_t* const of_groups = numbers.get() + 2 * tiles;
  detail::active_table().clouds.best_matches(
      raw(queries), {.first = detail::kQueryGroup * part, .step = detail::kQueryGroup * parts, .count = groups},
      raw(targets), of_queries.k_, raw_matches(of_queries), raw_matches(of_targets),
      {.boxes = of_groups + groups,
       .tiles_of_groups = of_groups,
       .groups_of_tiles = numbers.get(),
       .distances_of_tiles = numbers.get() + tiles});
}

}  // namespace consimd
