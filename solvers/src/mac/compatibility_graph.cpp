#include "mac/compatibility_graph.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "bits/bit_rows.hpp"
#include "sampling/counter_random.hpp"
#include "support/points.hpp"

namespace consimd::detail {
namespace {

// Deviations that an edge's common neighbours exceed chance by, in bins of a sixteenth.
constexpr std::size_t kBins = 8192;
constexpr double kBinsPerDeviation = 16.0;

using Histogram = std::vector<std::uint64_t>;

}  // namespace

CompatibilityGraph::CompatibilityGraph(const CorrespondenceView& view, double distance, double threshold,
                                       double max_mean_degree, std::uint64_t seed)
    : view_(view), squared_distance_(distance * view.scale() * distance * view.scale()) {
  matrix_.compute(view, distance * std::sqrt(1.0 - threshold));
  const std::span<const std::uint32_t> degrees = matrix_.degrees();
  const std::uint64_t ones = std::accumulate(degrees.begin(), degrees.end(), std::uint64_t{0});
  const double max_edges = 0.5 * max_mean_degree * static_cast<double>(view.size());
  if (0.5 * static_cast<double>(ones - view.size()) > max_edges) {
    sparsify(static_cast<std::uint64_t>(max_edges), seed);
  }
}

// The diagonal is set, which makes the ends of an edge common neighbours of it.
std::uint32_t CompatibilityGraph::common_neighbours(std::uint32_t i, std::uint32_t j) const {
  return and_popcount(matrix_.row(i), matrix_.row(j)) - 2;
}

float CompatibilityGraph::weight(std::uint32_t i, std::uint32_t j, bool second_order) const {
  const double difference = distance(source_point(view_, i), source_point(view_, j)) -
                            distance(target_point(view_, i), target_point(view_, j));
  const double score = std::max(1.0 - difference * difference / squared_distance_, 0.0);
  return static_cast<float>(second_order ? score * common_neighbours(i, j) : score);
}

// In a random graph of the same degrees the common neighbours are Poisson distributed.
std::uint32_t CompatibilityGraph::significance_bin(std::uint32_t i, std::uint32_t j) const {
  const std::span<const std::uint32_t> degrees = matrix_.degrees();
  const double expected =
      static_cast<double>(degrees[i] - 1) * static_cast<double>(degrees[j] - 1) / static_cast<double>(matrix_.size());
  const double deviations = (common_neighbours(i, j) - expected) / std::sqrt(expected + 1.0);
  return static_cast<std::uint32_t>(std::clamp(kBinsPerDeviation * deviations, 0.0, kBins - 1.0));
}

void CompatibilityGraph::sparsify(std::uint64_t max_edges, std::uint64_t seed) {
  const auto size = static_cast<std::uint32_t>(matrix_.size());
  const auto for_each_edge = [&](std::uint32_t i, const auto& visit) {
    const std::span<const std::uint64_t> row = matrix_.row(i);
    for (std::size_t w = i / kBlock; w < row.size(); ++w) {
      for_each_in_word(row[w], w, [&](std::uint32_t j) {
        if (j > i) visit(j);
      });
    }
  };
  tbb::enumerable_thread_specific<Histogram> histograms(Histogram(kBins, 0));
  tbb::parallel_for(std::uint32_t{0}, size, [&](std::uint32_t i) {
    Histogram& histogram = histograms.local();
    for_each_edge(i, [&](std::uint32_t j) { ++histogram[significance_bin(i, j)]; });
  });
  Histogram total(kBins, 0);
  for (const Histogram& part : histograms) {
    for (std::size_t b = 0; b < kBins; ++b) total[b] += part[b];
  }
  std::size_t cut = kBins - 1;  // edges above it stay, of those in it what there is room for
  std::uint64_t above = 0;
  while (cut > 0 && above + total[cut] <= max_edges) above += total[cut--];
  const double kept_share =
      static_cast<double>(max_edges - above) / static_cast<double>(std::max(total[cut], std::uint64_t{1}));

  std::vector<std::vector<std::uint32_t>> kept(size);
  tbb::parallel_for(std::uint32_t{0}, size, [&](std::uint32_t i) {
    for_each_edge(i, [&](std::uint32_t j) {
      const std::uint32_t bin = significance_bin(i, j);
      if (bin < cut) return;
      if (bin == cut) {
        CounterRandom random(seed, RandomStage::sparsification, std::uint64_t{i} * size + j);
        if (random() >= kept_share * 0x1p32) return;
      }
      kept[i].push_back(j);
    });
  });
  sparse_.assign_empty(size);
  for (std::uint32_t i = 0; i < size; ++i) {
    for (const std::uint32_t j : kept[i]) sparse_.connect(i, j);
  }
}

}  // namespace consimd::detail
