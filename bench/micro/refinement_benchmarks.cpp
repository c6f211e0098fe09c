#include "refinement_benchmarks.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <Eigen/Geometry>

#include <consimd/features/cell_grid.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/features/refinement.hpp>
#include <consimd/kernels/isa.hpp>

namespace consimd::bench {
namespace {

using features::CellGrid;
using Places = std::vector<std::array<double, 3>>;

constexpr std::size_t kSizes[] = {1'000, 15'000, 100'000};

/// Points of a road between uneven walls, 80 m by 20 m, with 2 cm of noise.
Places street(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&random] { return static_cast<std::int32_t>(random()) * 0x1p-31; };
  Places points(count);
  for (auto& p : points) {
    const double along = 40.0 * uniform();
    const double across = uniform();
    switch (random() % 4) {
      case 0:
        p = {along, 10.0 + std::sin(0.7 * along), 4.0 + 4.0 * across};
        break;
      case 1:
        p = {along, -10.0 - 0.5 * std::floor(std::fmod(along + 40.0, 6.0)), 4.0 + 4.0 * across};
        break;
      default:
        p = {along, 10.0 * across, 0.05 * along * across};
    }
    for (double& x : p) x += 0.02 * uniform();
  }
  return points;
}

Cloud cloud_of(const Places& points) {
  return Cloud(PointSpan<double>::interleaved(points.front().data(), points.size()));
}

/// Twice the mean distance of neighbours, about.
double spacing(std::size_t size) { return 2.0 * std::sqrt(2900.0 / static_cast<double>(size)); }

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

}  // namespace

void register_refinement_benchmarks() {
  for (const std::size_t size : kSizes) {
    for (const Isa isa : supported_isas()) {
      benchmark::RegisterBenchmark(fmt::format("nearest_within/{}/{}", size, to_string(isa)).c_str(),
                                   [=](benchmark::State& state) { measure_search(state, size, isa); });
    }
    for (const char* name : {"point", "plane", "gicp"}) {
      benchmark::RegisterBenchmark(fmt::format("refine/{}/{}", name, size).c_str(), [=](benchmark::State& state) {
        measure_refinement(state, size, features::parse_refinement_method(name));
      })->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace consimd::bench
