#include "verdict/kept_structure.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <utility>

#include <consimd/kernels/elementary_functions.hpp>

#include "support/points.hpp"
#include "verdict/kept_coordinates.hpp"

namespace consimd::detail {
namespace {

// At a second glance: all kinds that synthetic structure comes in, of a sample of the rows.
constexpr std::array kTelling{kept(Coordinate::least), kept(Coordinate::range), kept(Coordinate::from_centroid),
                              kept(Coordinate::least, Coordinate::middle),
                              kept(Coordinate::least, Coordinate::middle, Coordinate::greatest)};
constexpr std::size_t kSampledRows = 512;
constexpr std::size_t kSampledStratumRows = 16;

// Bits of a number, ascending as the numbers are.
std::uint32_t ascending_bits(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

// Sorts `order` by `key` of its members, which is below `keys`; equal keys stay in order.
template <typename Key>
void sort_by_key(std::vector<std::uint32_t>& order, std::size_t keys, const Key& key) {
  std::vector<std::uint32_t> end(keys + 1);
  for (const std::uint32_t i : order) ++end[key(i) + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<std::uint32_t> sorted(order.size());
  for (const std::uint32_t i : order) sorted[end[key(i)]++] = i;
  order.swap(sorted);
}

// One coordinate of the sources.
struct Axis {
  std::vector<float> values;
  std::vector<std::uint32_t> order;  // of the values, ascending
  double spread = 0.0;               // of the middle four fifths of them
};

Axis axis_of(std::vector<float> values) {
  constexpr unsigned kBits = 11;
  constexpr std::size_t kKeys = 1U << kBits;
  std::vector<std::uint32_t> bits(values.size());
  std::ranges::transform(values, bits.begin(), ascending_bits);
  Axis axis;
  axis.order.resize(values.size());
  std::iota(axis.order.begin(), axis.order.end(), 0U);
  for (unsigned shift = 0; shift < 32; shift += kBits) {
    sort_by_key(axis.order, kKeys, [&](std::uint32_t i) { return (bits[i] >> shift) % kKeys; });
  }
  const std::size_t tenth = values.size() / 10;
  axis.spread = static_cast<double>(values[axis.order[values.size() - 1 - tenth]]) -
                static_cast<double>(values[axis.order[tenth]]);
  axis.values = std::move(values);
  return axis;
}

// Into how many slabs each of the axes is cut, so that cells of about `rows` rows are about as long in all of them.
std::vector<std::size_t> slabs(std::span<const Axis* const> axes, std::size_t size, std::size_t rows) {
  const double cells = std::max(1.0, static_cast<double>(size) / static_cast<double>(rows));
  double volume = 1.0;
  for (const Axis* axis : axes) volume *= std::max(axis->spread, 1e-9);
  const double length = elementary::exp(elementary::log(volume / cells) / static_cast<double>(axes.size()));
  std::vector<std::size_t> result;
  for (const Axis* axis : axes) {
    result.push_back(static_cast<std::size_t>(std::clamp(std::round(axis->spread / length), 1.0, cells)));
  }
  return result;
}

// Strata of at most `largest` rows that agree in the axes: slabs of equal number along the first, each cut into such
// along the second, and so on.
Partition cut_into_slabs(std::span<const Axis* const> axes, std::size_t largest) {
  const std::size_t size = axes.front()->order.size();
  const std::vector<std::size_t> cuts = slabs(axes, size, largest);
  std::vector<std::uint32_t> cell(size);
  std::size_t cells = 1;
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> first;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    order = axes[a]->order;
    sort_by_key(order, cells, [&](std::uint32_t i) { return cell[i]; });
    const bool last = a + 1 == axes.size();
    for (std::size_t begin = 0; begin < order.size();) {
      const std::uint32_t of = cell[order[begin]];
      std::size_t end = begin;
      while (end < order.size() && cell[order[end]] == of) ++end;
      const std::size_t parts = last ? (end - begin + largest - 1) / largest : cuts[a];
      for (std::size_t part = 0; part < parts; ++part) {
        const std::size_t from = begin + part * (end - begin) / parts;
        const std::size_t to = begin + (part + 1) * (end - begin) / parts;
        if (last && from < to) first.push_back(static_cast<std::uint32_t>(from));
        if (last) continue;
        for (std::size_t position = from; position < to; ++position) {
          cell[order[position]] = static_cast<std::uint32_t>(of * parts + part);
        }
      }
      begin = end;
    }
    cells *= cuts[a];
  }
  first.push_back(static_cast<std::uint32_t>(order.size()));
  return {std::move(order), std::move(first)};
}

// Halves rows at the median of their widest coordinate until strata are left.
class Halving {
 public:
  Halving(std::span<const Axis* const> axes, std::size_t largest)
      : axes_(axes.begin(), axes.end()), largest_(largest), upper_(axes_.front()->order.size()) {
    for (const Axis* axis : axes_) orders_.push_back(axis->order);
    if (!upper_.empty()) split(0, upper_.size());
    first_.push_back(static_cast<std::uint32_t>(upper_.size()));
  }

  [[nodiscard]] Partition partition() && { return {std::move(orders_.front()), std::move(first_)}; }

 private:
  void split(std::size_t begin, std::size_t end) {
    if (end - begin <= largest_) {
      first_.push_back(static_cast<std::uint32_t>(begin));
      return;
    }
    std::size_t widest = 0;
    float largest = -1.0F;
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      const float extent = axes_[a]->values[orders_[a][end - 1]] - axes_[a]->values[orders_[a][begin]];
      if (extent > largest) {
        largest = extent;
        widest = a;
      }
    }
    const std::size_t half = begin + (end - begin) / 2;
    for (std::size_t position = begin; position < end; ++position) {
      upper_[orders_[widest][position]] = position >= half ? 1 : 0;
    }
    // The orders along the other axes stay orders in each half.
    scratch_.resize(end - half + 1);
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      if (a == widest) continue;
      std::size_t low = begin;
      std::size_t high = 0;
      for (std::size_t position = begin; position < end; ++position) {
        // Written to both, kept in one: no branch could be foretold.
        const std::uint32_t i = orders_[a][position];
        scratch_[high] = i;
        orders_[a][low] = i;
        high += upper_[i];
        low += 1U - upper_[i];
      }
      std::copy_n(scratch_.begin(), end - half, orders_[a].begin() + static_cast<std::ptrdiff_t>(half));
    }
    split(begin, half);
    split(half, end);
  }

  std::vector<const Axis*> axes_;
  std::size_t largest_;
  std::vector<std::uint8_t> upper_;
  std::vector<std::vector<std::uint32_t>> orders_;
  std::vector<std::uint32_t> scratch_;
  std::vector<std::uint32_t> first_;
};

}  // namespace

// Every `step`-th row, along every coordinate.
struct KeptStructure::Sorted {
  Sorted(const Correspondences& correspondences, std::size_t step);

  // Strata of rows that share the coordinates. `both_ways`: rows are cut twice where there is more than one way.
  [[nodiscard]] std::vector<Partition> partitions(const Kept& kept, std::size_t largest, bool both_ways) const {
    std::vector<const Axis*> along;
    for (const Coordinate c : kept.all()) along.push_back(&axes[index_of(c)]);
    std::vector<Partition> result{cut_into_slabs(along, largest)};
    if (both_ways && kept.count > 1) result.push_back(Halving(along, largest).partition());
    for (Partition& partition : result) {
      for (std::uint32_t& i : partition.rows) i = rows[i];
    }
    return result;
  }

  std::vector<std::uint32_t> rows;
  std::array<Axis, kCoordinates> axes;
};

KeptStructure::Sorted::Sorted(const Correspondences& correspondences, std::size_t step) {
  const CorrespondenceView view = correspondences.view();
  const SourceCoordinates coordinates_of(correspondences, step);
  std::array<std::vector<float>, kCoordinates> coordinates;
  for (std::size_t k = 0; k < view.size(); k += step) {
    rows.push_back(static_cast<std::uint32_t>(k));
    const std::array<float, kCoordinates> here = coordinates_of(source_point(view, k));
    for (std::size_t c = 0; c < kCoordinates; ++c) coordinates[c].push_back(here[c]);
  }
  for (std::size_t c = 0; c < kCoordinates; ++c) axes[c] = axis_of(std::move(coordinates[c]));
}

KeptStructure::KeptStructure(const Correspondences& correspondences)
    : correspondences_(&correspondences), partitions_(kKept.size()) {}

std::size_t KeptStructure::kinds() const { return kKept.size(); }

std::vector<Strata> KeptStructure::strata(std::size_t kind, double apart) const {
  std::call_once(is_sorted_, [&] { sorted_ = std::make_shared<const Sorted>(*correspondences_, 1); });
  std::vector<Partition>& partitions = partitions_[kind];
  if (partitions.empty()) partitions = sorted_->partitions(kKept[kind], kStratumRows, true);
  std::vector<Strata> result;
  result.reserve(partitions.size());
  for (const Partition& partition : partitions) result.emplace_back(correspondences_->view(), partition, apart);
  return result;
}

std::vector<Strata> KeptStructure::sampled(const Correspondences& correspondences, double apart) {
  const Sorted sorted(correspondences, std::max<std::size_t>(1, correspondences.size() / kSampledRows));
  std::vector<Strata> result;
  for (const Kept& kept : kTelling) {
    for (Partition& partition : sorted.partitions(kept, kSampledStratumRows, false)) {
      result.emplace_back(correspondences.view(), std::move(partition), apart);
    }
  }
  return result;
}

}  // namespace consimd::detail
