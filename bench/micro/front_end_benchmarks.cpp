#include "front_end_benchmarks.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <consimd/features/cell_grid.hpp>
#include <consimd/features/fpfh.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/kernels/descriptor_matches.hpp>
#include <consimd/kernels/isa.hpp>
#include <consimd/kernels/neighbourhoods.hpp>
#include <consimd/kernels/pair_features.hpp>

#include "street.hpp"

namespace consimd::bench {
namespace {

using features::CellGrid;
using features::NeighbourLists;
using Words = std::vector<std::uint32_t>;
/// Runs a kernel on all that was prepared, on the active instruction set. What it found, as bits.
using Run = std::function<void(Words&)>;

constexpr std::size_t kCloudSizes[] = {1'000, 15'000};
constexpr std::size_t kDescriptorCounts[] = {1'000, 5'000};

std::vector<std::uint32_t> all_rows(const CellGrid& grid) {
  std::vector<std::uint32_t> rows(grid.size());
  std::iota(rows.begin(), rows.end(), 0U);
  return rows;
}

double radius_for(std::size_t size) { return 2.5 * spacing(size); }

CellGrid grid_with_normals(std::size_t size, std::uint32_t seed) {
  CellGrid grid(cloud_of(street(size, seed)), radius_for(size));
  features::estimate_normals(grid, {.radius = radius_for(size)});
  return grid;
}

void append(std::span<const float> values, Words& words) {
  for (const float value : values) words.push_back(std::bit_cast<std::uint32_t>(value));
}

/// A cloud and the neighbours of all its points.
struct Scene {
  explicit Scene(std::size_t size)
      : radius(radius_for(size)),
        grid(grid_with_normals(size, 1)),
        lists(features::radius_neighbours(grid, all_rows(grid), radius)) {}

  [[nodiscard]] std::span<const std::uint32_t> neighbours(std::size_t row) const {
    return std::span(lists.rows).subspan(lists.starts[row], lists.starts[row + 1] - lists.starts[row]);
  }
  [[nodiscard]] std::array<float, 3> point(std::size_t row) const {
    const CloudView cloud = grid.cloud().view();
    return {cloud.points(0)[row], cloud.points(1)[row], cloud.points(2)[row]};
  }

  double radius;
  CellGrid grid;
  NeighbourLists lists;
};

/// A kernel's work, and how many items it is.
struct Work {
  Run run;
  std::size_t items;
  const char* label;
};

Work neighbours(std::size_t size) {
  const auto scene = std::make_shared<Scene>(size);
  return {[scene, rows = all_rows(scene->grid)](Words& words) {
            words = features::radius_neighbours(scene->grid, rows, scene->radius).rows;
          },
          scene->lists.rows.size(), "neighbours"};
}

Work scatter(std::size_t size) {
  const auto scene = std::make_shared<Scene>(size);
  return {[scene](Words& words) {
            words.clear();
            for (std::size_t row = 0; row < scene->grid.size(); ++row) {
              append(neighbourhood_scatter(scene->grid.cloud().view(), scene->point(row), scene->neighbours(row),
                                           scene->radius),
                     words);
            }
          },
          scene->lists.rows.size(), "neighbours"};
}

Work axes(std::size_t size) {
  const Scene scene(size);
  const auto batches =
      std::make_shared<std::vector<ScatterBatch>>((size + ScatterBatch::kSize - 1) / ScatterBatch::kSize);
  for (std::size_t row = 0; row < size; ++row) {
    const std::array<float, 6> matrix =
        neighbourhood_scatter(scene.grid.cloud().view(), scene.point(row), scene.neighbours(row), scene.radius);
    ScatterBatch& batch = (*batches)[row / ScatterBatch::kSize];
    for (std::size_t k = 0; k < 6; ++k) batch.entries[k][row % ScatterBatch::kSize] = matrix[k];
  }
  return {[batches](Words& words) {
            words.clear();
            PrincipalAxes found;
            for (const ScatterBatch& batch : *batches) {
              principal_axes(batch, ScatterBatch::kSize, found);
              for (std::size_t k = 0; k < 3; ++k) {
                append(found.values[k], words);
                append(found.smallest_axes[k], words);
              }
            }
          },
          batches->size() * ScatterBatch::kSize, "matrices"};
}

Work pair_features(std::size_t size) {
  const auto scene = std::make_shared<Scene>(size);
  return {[scene](Words& words) {
            words.assign(kPairFeatureBins * scene->grid.size(), 0);
            for (std::uint32_t row = 0; row < scene->grid.size(); ++row) {
              pair_feature_counts(scene->grid.cloud().view(), row, scene->neighbours(row),
                                  std::span(words).subspan(kPairFeatureBins * row).first<kPairFeatureBins>());
            }
          },
          scene->lists.rows.size(), "pairs"};
}

/// Rows of a table of histograms, aligned as the kernel asks.
struct alignas(64) Histogram {
  float bins[kHistogramStride] = {};
};

Work histogram_sums(std::size_t size) {
  const auto scene = std::make_shared<Scene>(size);
  const auto table = std::make_shared<std::vector<Histogram>>(size);
  for (std::uint32_t row = 0; row < size; ++row) {
    std::array<std::uint32_t, kPairFeatureBins> counts{};
    pair_feature_counts(scene->grid.cloud().view(), row, scene->neighbours(row), counts);
    std::copy(counts.begin(), counts.end(), (*table)[row].bins);
  }
  const auto squared = std::make_shared<std::vector<float>>(scene->lists.distances.size());
  std::transform(scene->lists.distances.begin(), scene->lists.distances.end(), squared->begin(),
                 [](double distance) { return static_cast<float>(distance * distance); });
  return {[scene, table, squared](Words& words) {
            words.clear();
            Histogram sum;
            const std::span<const float> values(table->front().bins, kHistogramStride * table->size());
            for (std::size_t row = 0; row < scene->grid.size(); ++row) {
              const std::span<const std::uint32_t> near = scene->neighbours(row);
              weighted_histogram_sum(values, near, std::span(*squared).subspan(scene->lists.starts[row], near.size()),
                                     sum.bins);
              append(sum.bins, words);
            }
          },
          scene->lists.rows.size(), "histograms"};
}

Work matches(std::size_t count) {
  constexpr std::size_t kBest = 3;
  // A third of the points is described, as keypoints are a part of a cloud.
  const auto describe = [count](std::uint32_t seed) {
    const CellGrid grid = grid_with_normals(3 * count, seed);
    std::vector<std::uint32_t> rows;
    for (std::uint32_t row = 0; row < grid.size(); row += 3) rows.push_back(row);
    return features::fpfh(grid, rows, grid.cell());
  };
  const features::Descriptors source = describe(1), target = describe(2);
  const FixedPointForm form(source.values, target.values, source.length);
  const auto fixed = [&form](const features::Descriptors& descriptors) {
    return std::make_shared<FixedPointDescriptors>(descriptors.values, form);
  };
  return {[of_source = fixed(source), of_target = fixed(target)](Words& words) {
            BestMatches best(*of_source, kBest), best_of_target(*of_target, kBest);
            best_matches(*of_source, *of_target, best, best_of_target);
            words.clear();
            for (const BestMatches* lists : {&best, &best_of_target}) {
              for (std::size_t i = 0; i < lists->size(); ++i) {
                for (std::size_t rank = 0; rank < kBest; ++rank) words.push_back(lists->index(i, rank));
              }
            }
          },
          source.size() * target.size(), "distances"};
}

void measure(benchmark::State& state, Isa isa, const Work& work) {
  tbb::task_arena arena(1);
  Words expected, words;
  set_active_isa(Isa::scalar);
  arena.execute([&] { work.run(expected); });
  set_active_isa(isa);
  arena.execute([&] { work.run(words); });
  if (words != expected) {
    state.SkipWithError("differs from the scalar reference");
    return;
  }
  arena.execute([&] {
    for (auto _ : state) work.run(words);
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(work.items));
  state.SetLabel(work.label);
}

void register_kernel(const char* name, std::span<const std::size_t> sizes, Work (*make)(std::size_t)) {
  for (const std::size_t size : sizes) {
    for (const Isa isa : supported_isas()) {
      benchmark::RegisterBenchmark(fmt::format("{}/{}/{}", name, size, to_string(isa)).c_str(),
                                   [=](benchmark::State& state) { measure(state, isa, make(size)); });
    }
  }
}

}  // namespace

void register_front_end_benchmarks() {
  register_kernel("neighbours_within", kCloudSizes, neighbours);
  register_kernel("neighbourhood_scatter", kCloudSizes, scatter);
  register_kernel("principal_axes", kCloudSizes, axes);
  register_kernel("pair_feature_counts", kCloudSizes, pair_features);
  register_kernel("weighted_histogram_sum", kCloudSizes, histogram_sums);
  register_kernel("best_matches", kDescriptorCounts, matches);
}

}  // namespace consimd::bench
