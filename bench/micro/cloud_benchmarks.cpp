#include "cloud_benchmarks.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <Eigen/Geometry>

#include <consimd/features/cell_grid.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/features/point_subset.hpp>
#include <consimd/features/refinement.hpp>
#include <consimd/kernels/isa.hpp>
#include <consimd/kernels/pair_equations.hpp>

#include "street.hpp"

namespace consimd::bench {
namespace {

using features::CellGrid;

constexpr std::size_t kSizes[] = {1'000, 15'000, 100'000};

void measure_search(benchmark::State& state, std::size_t size, Isa isa) {
  const double radius = spacing(size);
  const CellGrid grid(cloud_of(street(size, 1)), radius);
  const Places queries = street(size, 2);
  set_active_isa(Isa::scalar);
  const features::NearestLists expected = features::nearest_neighbours(grid, queries, 2, radius);
  set_active_isa(isa);
  tbb::task_arena arena(1);
  features::NearestLists found;
  const auto search = [&] {
    found = arena.execute([&] { return features::nearest_neighbours(grid, queries, 2, radius); });
  };
  search();
  if (found.rows != expected.rows || found.distances != expected.distances) {
    state.SkipWithError("differs from the scalar reference");
    return;
  }
  for (auto _ : state) search();
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(size));
  state.SetLabel("queries");
}

/// The points of one street as blocks beside the nearest ones of another.
std::vector<PairBlock> pairs_of(const CellGrid& target, std::size_t size) {
  const Places moved = street(size, 2);
  const features::NearestLists nearest = features::nearest_neighbours(target, moved, 1, spacing(size));
  std::vector<PairBlock> blocks((size + PairBlock::kSize - 1) / PairBlock::kSize);
  for (std::size_t i = 0; i < size; ++i) {
    PairBlock& block = blocks[i / PairBlock::kSize];
    const std::size_t k = i % PairBlock::kSize;
    const std::array<double, 3> point = target.cloud().to_working_frame(moved[i]);
    const std::uint32_t row = nearest.rows[i];
    block.rows[k] = std::min(row, static_cast<std::uint32_t>(target.size()));
    for (std::size_t c = 0; c < 3; ++c) {
      block.points[c][k] = block.from[c][k] = static_cast<float>(point[c]);
      block.normals[c][k] = block.rows[k] == row ? target.cloud().view().normals(c)[row] : 0.0f;
      block.looked[c][k] = block.from[c][k] + 0.001f;
    }
    block.trust[k] = static_cast<float>(k % 7) * 5e-4f;
  }
  return blocks;
}

/// What a kernel makes of blocks of pairs, as bytes.
using Words = std::vector<std::uint32_t>;
using OnBlocks = void (*)(const CloudView& target, std::vector<PairBlock>& blocks, std::size_t size, double unit,
                          Words& words);

std::size_t entries(std::size_t b, std::size_t size) { return std::min(PairBlock::kSize, size - b * PairBlock::kSize); }

void move_blocks(const CloudView& /*target*/, std::vector<PairBlock>& blocks, std::size_t size, double /*unit*/,
                 Words& words) {
  const WorkingMotion motion{
      {1.0f, -0.001f, 0.0f, 0.001f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f}, {0.001f, 0.0f, 0.0f}, {}, {1e-10f, 0.0f, 0.0f}};
  words.clear();
  std::array<std::uint64_t, PairBlock::kSize / 64> stale;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    move_pairs(blocks[b], entries(b, size), motion, stale);
    for (const std::uint64_t word : stale) words.push_back(static_cast<std::uint32_t>(word ^ word >> 32U));
    words.push_back(std::bit_cast<std::uint32_t>(blocks[b].points[0][0]));
  }
}

template <PairMetric kMetric>
PairProblem problem_of(double unit) {
  return {kMetric,
          {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f},
          {},
          static_cast<float>(unit),
          static_cast<float>(0.05 * unit)};
}

template <PairMetric kMetric>
void residuals_of_blocks(const CloudView& target, std::vector<PairBlock>& blocks, std::size_t size, double unit,
                         Words& words) {
  std::array<float, PairBlock::kSize> squared;
  words.assign(size, 0);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const std::size_t n = entries(b, size);
    pair_residuals(target, blocks[b], n, problem_of<kMetric>(unit), std::span(squared).first(n));
    std::memcpy(words.data() + b * PairBlock::kSize, squared.data(), n * sizeof(float));
  }
}

template <PairMetric kMetric>
void equations_of_blocks(const CloudView& target, std::vector<PairBlock>& blocks, std::size_t size, double unit,
                         Words& words) {
  constexpr std::size_t kWords = sizeof(PairEquations) / sizeof(std::uint32_t);
  words.assign(kWords * blocks.size(), 0);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const PairEquations equations = pair_equations(target, blocks[b], entries(b, size), problem_of<kMetric>(unit));
    std::memcpy(words.data() + b * kWords, &equations, sizeof(equations));
  }
}

void measure_pairs(benchmark::State& state, std::size_t size, Isa isa, OnBlocks kernel) {
  const double reach = 2.0 * spacing(size);
  CellGrid grid(cloud_of(street(size, 1)), reach);
  features::estimate_normals(grid, {.radius = reach});
  std::vector<PairBlock> blocks = pairs_of(grid, size);
  const CloudView target = grid.cloud().view();
  const double unit = reach * target.scale();
  Words expected, words;
  set_active_isa(Isa::scalar);
  kernel(target, blocks, size, unit, expected);
  set_active_isa(isa);
  kernel(target, blocks, size, unit, words);
  if (words != expected) {
    state.SkipWithError("differs from the scalar reference");
    return;
  }
  for (auto _ : state) kernel(target, blocks, size, unit, words);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(size));
  state.SetLabel("pairs");
}

/// The subset by each point's distance to each chosen one, from the same first.
std::vector<std::uint32_t> farthest_by_loop(const CloudView& cloud, std::size_t count, std::uint32_t first) {
  std::vector<float> nearest(cloud.size(), std::numeric_limits<float>::infinity());
  std::vector<std::uint32_t> rows{first};
  while (rows.size() < count) {
    const std::uint32_t last = rows.back();
    nearest[last] = -1.0f;  // never again
    std::uint32_t farthest = 0;
    for (std::uint32_t row = 0; row < nearest.size(); ++row) {
      float squared = 0.0f;
      for (std::size_t c = 0; c < 3; ++c) {
        const float offset = cloud.points(c)[row] - cloud.points(c)[last];
        squared += offset * offset;
      }
      nearest[row] = std::min(nearest[row], squared);
      if (nearest[row] > nearest[farthest]) farthest = row;
    }
    rows.push_back(farthest);
  }
  return rows;
}

void measure_subset(benchmark::State& state, std::size_t size, bool by_loop) {
  const Cloud cloud = cloud_of(street(size, 1));
  const std::size_t count = size / 3;
  std::vector<std::uint32_t> rows = features::farthest_subset(cloud, count, 1);
  const std::uint32_t first = rows.front();
  if (!by_loop && rows != farthest_by_loop(cloud.view(), count, first)) {
    state.SkipWithError("differs from the plain loop");
    return;
  }
  for (auto _ : state) {
    rows = by_loop ? farthest_by_loop(cloud.view(), count, first) : features::farthest_subset(cloud, count, 1);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
  state.SetLabel("chosen");
}

void measure_refinement(benchmark::State& state, std::size_t size, features::RefinementMethod method) {
  const auto prepared = [size](std::uint32_t seed) {
    CellGrid grid(cloud_of(street(size, seed)), 2.0 * spacing(size));
    features::estimate_normals(grid, {.radius = 2.0 * spacing(size)});
    return grid;
  };
  const CellGrid source = prepared(1), target = prepared(2);
  RigidTransform start = RigidTransform::Identity();
  start.rotate(Eigen::AngleAxisd(0.004, Eigen::Vector3d::UnitZ()));
  start.translation() << 0.2, -0.1, 0.1;
  tbb::task_arena arena(1);
  features::Refinement refined;
  for (auto _ : state) {
    refined = arena.execute([&] {
      return features::refine(source.cloud(), target.cloud(), start,
                              {.method = method, .max_distance = 2.0 * spacing(size)});
    });
  }
  if (!refined.has_pose()) state.SkipWithError(std::string(to_string(refined.status)).c_str());
  state.counters["steps"] = refined.iterations;
}

constexpr std::pair<const char*, OnBlocks> kPairKernels[] = {
    {"move_pairs", move_blocks},
    {"pair_residuals/plane", residuals_of_blocks<PairMetric::plane>},
    {"pair_equations/point", equations_of_blocks<PairMetric::point>},
    {"pair_equations/plane", equations_of_blocks<PairMetric::plane>},
    {"pair_equations/gicp", equations_of_blocks<PairMetric::gicp>},
};
// The plain loop takes size^2 / 3 distances.
constexpr std::size_t kMostOfLoop = 15'000;

}  // namespace

void register_cloud_benchmarks() {
  for (const std::size_t size : kSizes) {
    for (const Isa isa : supported_isas()) {
      benchmark::RegisterBenchmark(fmt::format("nearest_within/{}/{}", size, to_string(isa)).c_str(),
                                   [=](benchmark::State& state) { measure_search(state, size, isa); });
    }
    for (const auto& [name, kernel] : kPairKernels) {
      for (const Isa isa : supported_isas()) {
        benchmark::RegisterBenchmark(
            fmt::format("{}/{}/{}", name, size, to_string(isa)).c_str(),
            [size, isa, run = kernel](benchmark::State& state) { measure_pairs(state, size, isa, run); });
      }
    }
    if (size <= kMostOfLoop) {
      for (const bool by_loop : {false, true}) {
        benchmark::RegisterBenchmark(fmt::format("farthest_subset/{}{}", size, by_loop ? "/loop" : "").c_str(),
                                     [=](benchmark::State& state) { measure_subset(state, size, by_loop); })
            ->Unit(benchmark::kMillisecond);
      }
    }
    for (const char* name : {"point", "plane", "gicp"}) {
      benchmark::RegisterBenchmark(fmt::format("refine/{}/{}", name, size).c_str(), [=](benchmark::State& state) {
        measure_refinement(state, size, features::parse_refinement_method(name));
      })->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace consimd::bench
