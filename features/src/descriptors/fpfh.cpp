#include <consimd/features/fpfh.hpp>

#include <consimd/kernels/pair_features.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>

#include "grid/neighbourhoods.hpp"

namespace consimd::features {
namespace {

constexpr std::size_t kBins = 11;

/// Histograms as `weighted_histogram_sum` reads them.
class HistogramTable {
 public:
  explicit HistogramTable(std::size_t rows)
      : size_(rows * kHistogramStride),
        data_(static_cast<float*>(::operator new[](size_ * sizeof(float), std::align_val_t{64}))) {}

  [[nodiscard]] std::span<const float> values() const noexcept { return {data_.get(), size_}; }
  [[nodiscard]] float* row(std::size_t i) const noexcept { return data_.get() + i * kHistogramStride; }

 private:
  struct Delete {
    void operator()(float* p) const noexcept { ::operator delete[](p, std::align_val_t{64}); }
  };
  std::size_t size_;
  std::unique_ptr<float[], Delete> data_;
};

/// Ascending: the neighbours of all of `rows`.
std::vector<std::uint32_t> needed_rows(const CellGrid& grid, std::span<const std::uint32_t> rows, double radius) {
  std::vector<std::atomic<std::uint8_t>> needed(grid.size());
  detail::visit_neighbourhoods(grid, rows, radius, [&](std::size_t, const detail::Neighbourhood& near) {
    for (const std::uint32_t row : near.rows) needed[row].store(1, std::memory_order_relaxed);
  });
  std::vector<std::uint32_t> list;
  for (std::uint32_t row = 0; row < grid.size(); ++row) {
    if (needed[row].load(std::memory_order_relaxed) != 0) list.push_back(row);
  }
  return list;
}

/// Shares of the pairs of a point with its neighbours, in percent.
void write_spfh(const CloudView& cloud, const detail::Neighbourhood& near, float* histogram) {
  std::array<std::uint32_t, kPairFeatureBins> counts{};
  pair_feature_counts(cloud, near.row, near.rows, counts);
  std::fill_n(histogram, kHistogramStride, 0.0f);
  if (near.rows.size() < 2) return;
  const float percent = 100.0f / static_cast<float>(near.rows.size() - 1);
  for (std::size_t bin = 0; bin < kPairFeatureBins; ++bin) histogram[bin] = percent * static_cast<float>(counts[bin]);
}

/// Brings the sum of each feature's bins to 100; false where there is none.
bool normalise(const float* sum, float* descriptor) {
  for (std::size_t f = 0; f < 3; ++f) {
    float total = 0.0f;
    for (std::size_t b = 0; b < kBins; ++b) total += sum[f * kBins + b];
    if (!(total > 0.0f) || !std::isfinite(total)) return false;
    for (std::size_t b = 0; b < kBins; ++b) descriptor[f * kBins + b] = 100.0f / total * sum[f * kBins + b];
  }
  return true;
}

}  // namespace

Descriptors fpfh(const CellGrid& grid, std::span<const std::uint32_t> rows, double radius) {
  detail::require_radius(grid, radius, "descriptor radius");
  detail::require_ascending(rows, grid.size());
  const CloudView cloud = grid.cloud().view();
  if (!cloud.has_normals()) throw std::invalid_argument("the cloud has no normals: estimate them first");

  // Where many are asked for, nearly all are needed.
  constexpr std::size_t kFew = 8;
  const std::vector<std::uint32_t> needed =
      kFew * rows.size() < grid.size() ? needed_rows(grid, rows, radius) : detail::all_rows(grid.size());
  const HistogramTable spfh(needed.size());
  std::vector<std::uint32_t> places(grid.size(), 0);
  for (std::uint32_t k = 0; k < needed.size(); ++k) places[needed[k]] = k;
  detail::visit_neighbourhoods(grid, needed, radius, [&](std::size_t k, const detail::Neighbourhood& near) {
    write_spfh(cloud, near, spfh.row(k));
  });

  std::vector<float> values(kPairFeatureBins * rows.size());
  std::vector<std::uint8_t> complete(rows.size(), 0);
  detail::search_in_parts(grid, rows, radius, [&](std::size_t begin, std::size_t end, const auto& search) {
    alignas(64) std::array<float, kHistogramStride> sum;
    std::vector<std::uint32_t> histograms;
    for (std::size_t k = begin; k < end; ++k) {
      const detail::Neighbourhood near = search(k);
      histograms.resize(near.rows.size());
      std::transform(near.rows.begin(), near.rows.end(), histograms.begin(),
                     [&](std::uint32_t row) { return places[row]; });
      weighted_histogram_sum(spfh.values(), histograms, near.squared_distances, sum);
      complete[k] = normalise(sum.data(), values.data() + kPairFeatureBins * k) ? 1 : 0;
    }
  });

  Descriptors result{kPairFeatureBins, {}, std::move(values)};
  result.rows.reserve(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (complete[k] == 0) continue;
    std::copy_n(result.values.begin() + static_cast<std::ptrdiff_t>(kPairFeatureBins * k), kPairFeatureBins,
                result.values.begin() + static_cast<std::ptrdiff_t>(kPairFeatureBins * result.rows.size()));
    result.rows.push_back(rows[k]);
  }
  result.values.resize(kPairFeatureBins * result.rows.size());
  return result;
}

}  // namespace consimd::features
