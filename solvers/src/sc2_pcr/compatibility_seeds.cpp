// The first stages of SC2-PCR: confidence of correspondences, seeds.
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <consimd/solvers/sc2_pcr.hpp>

#include "support/points.hpp"

namespace consimd {
namespace {

constexpr std::size_t kRowsPerTask = 128;
// No entry changes by more than this part of itself: the power iteration has converged.
constexpr double kSmallestChange = 1e-5;

/// Whether each source is without a more confident one within `radius`, working frame.
std::vector<std::uint8_t> local_maxima(const CorrespondenceView& view, std::span<const float> confidence,
                                       double radius) {
  // Sorted along one axis, candidates are neighbours in the order.
  std::vector<std::uint32_t> order(view.size());
  std::iota(order.begin(), order.end(), 0U);
  const float* x = view.source(0);
  std::ranges::stable_sort(order, {}, [x](std::uint32_t row) { return x[row]; });
  std::vector<std::uint8_t> is_maximum(view.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), kRowsPerTask), [&](const auto& range) {
    for (std::size_t position = range.begin(); position < range.end(); ++position) {
      const std::uint32_t row = order[position];
      const detail::Point p = detail::source_point(view, row);
      const auto near = [&](std::uint32_t other) { return std::abs(x[other] - x[row]) < radius; };
      const auto exceeds = [&](std::uint32_t other) {
        return confidence[other] > confidence[row] && detail::distance(p, detail::source_point(view, other)) < radius;
      };
      bool exceeded = false;
      for (std::size_t k = position; !exceeded && k > 0 && near(order[k - 1]); --k) exceeded = exceeds(order[k - 1]);
      for (std::size_t k = position + 1; !exceeded && k < order.size() && near(order[k]); ++k) {
        exceeded = exceeds(order[k]);
      }
      is_maximum[row] = exceeded ? 0 : 1;
    }
  });
  return is_maximum;
}

}  // namespace

std::vector<float> compatibility_confidence(const ConsistencyMatrix& matrix, std::uint32_t max_rounds) {
  const std::size_t size = matrix.size();
  std::vector<float> confidence(matrix.words() * kBlock);
  if (size == 0) return confidence;
  std::fill_n(confidence.begin(), size, 1.0F / std::sqrt(static_cast<float>(size)));
  std::vector<float> sums(size);
  for (std::uint32_t round = 0; round < max_rounds; ++round) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, size, kRowsPerTask), [&](const auto& range) {
      masked_row_sums(matrix, range.begin(), confidence, std::span(sums).subspan(range.begin(), range.size()));
    });
    double squares = 0.0;
    for (const float sum : sums) squares += static_cast<double>(sum) * static_cast<double>(sum);
    if (!(squares > 0.0)) break;
    const double length = std::sqrt(squares);
    bool converged = true;
    for (std::size_t row = 0; row < size; ++row) {
      const auto next = static_cast<float>(static_cast<double>(sums[row]) / length);
      if (std::abs(next - confidence[row]) > kSmallestChange * std::abs(confidence[row])) converged = false;
      confidence[row] = next;
    }
    if (converged) break;
  }
  confidence.resize(size);
  return confidence;
}

std::vector<std::uint32_t> confidence_seeds(const CorrespondenceView& view, std::span<const float> confidence,
                                            double radius, std::size_t count) {
  const std::vector<std::uint8_t> is_maximum = local_maxima(view, confidence, radius * view.scale());
  std::vector<std::uint32_t> seeds(view.size());
  std::iota(seeds.begin(), seeds.end(), 0U);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    if (is_maximum[a] != is_maximum[b]) return is_maximum[a] > is_maximum[b];
    return confidence[a] > confidence[b] || (confidence[a] == confidence[b] && a < b);
  };
  count = std::min(count, seeds.size());
  std::ranges::partial_sort(seeds, seeds.begin() + static_cast<std::ptrdiff_t>(count), before);
  seeds.resize(count);
  return seeds;
}

}  // namespace consimd
