// The stages from clouds to correspondences.
#include <consimd/features/cell_grid.hpp>
#include <consimd/features/fpfh.hpp>
#include <consimd/features/iss.hpp>
#include <consimd/features/matching.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/features/point_subset.hpp>
#include <consimd/features/voxel_grid.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>

#include "array_results.hpp"
#include "bindings.hpp"
#include "cloud_calls.hpp"

namespace consimd::python {
namespace {

Array<double, -1, 3> voxel_grid(ArrayLike points, double voxel, std::optional<double> missing,
                                std::optional<int> threads) {
  return points_array(*result_of(threads, [cloud = shared_cloud(points, "points", missing), voxel] {
    const Cloud voxels = features::voxel_grid(*cloud, voxel);
    std::vector<std::array<double, 3>> means;
    means.reserve(voxels.size());
    for (std::size_t i = 0; i < voxels.size(); ++i) means.push_back(voxels.point(i));
    return means;
  }));
}

Array<std::int64_t, -1> farthest_subset(ArrayLike points, std::size_t count, std::uint64_t seed,
                                        std::optional<double> missing, std::optional<int> threads) {
  const auto cloud = shared_cloud(points, "points", missing);
  auto rows = result_of(threads, [cloud, count, seed] {
    std::vector<std::int64_t> chosen;
    for (const std::uint32_t row : features::farthest_subset(*cloud, count, seed)) {
      chosen.push_back(cloud->input_row(row));
    }
    return chosen;
  });
  return to_array(std::move(*rows));
}

double checked_radius(double radius) {
  if (std::isfinite(radius) && radius > 0.0) return radius;
  throw std::invalid_argument("radius is " + std::to_string(radius) + ", expected a finite length above 0");
}

/// A grid with normals, and the row of the caller's array that each of its points is.
struct DescribedCloud {
  features::CellGrid grid;
  std::vector<std::uint32_t> input_rows;

  DescribedCloud(const Cloud& cloud, double radius, double normal_radius, const Viewpoint& viewpoint)
      : grid(cloud, checked_radius(radius)), input_rows(cloud.size()) {
    features::estimate_normals(grid, {normal_radius, viewpoint});
    for (std::size_t row = 0; row < grid.size(); ++row) input_rows[row] = cloud.input_row(grid.original(row));
  }
};

Array<float, -1, 3> normals(ArrayLike points, double radius, const Viewpoint& viewpoint, std::optional<double> missing,
                            std::optional<int> threads) {
  const auto cloud = shared_cloud(points, "points", missing);
  const std::size_t size = cloud->size() + cloud->left_out();
  auto values = result_of(threads, [cloud, size, radius, viewpoint] {
    std::vector<float> found(3 * size, std::numeric_limits<float>::quiet_NaN());
    const DescribedCloud described(*cloud, radius, radius, viewpoint);
    const CloudView view = described.grid.cloud().view();
    for (std::size_t row = 0; row < view.size(); ++row) {
      for (std::size_t c = 0; c < 3; ++c) found[3 * described.input_rows[row] + c] = view.normals(c)[row];
    }
    return found;
  });
  return to_array<Array<float, -1, 3>>(std::move(*values), {size, 3});
}

Array<std::int64_t, -1> iss_keypoints(ArrayLike points, double radius, double suppression_radius,
                                      double second_to_first, double third_to_second, std::size_t fewest_neighbours,
                                      std::optional<double> missing, std::optional<int> threads) {
  const features::IssOptions options{checked_radius(radius), suppression_radius, second_to_first, third_to_second,
                                     fewest_neighbours};
  auto rows = result_of(threads, [cloud = shared_cloud(points, "points", missing), options] {
    std::vector<std::int64_t> keypoints;
    const features::CellGrid grid(*cloud, std::max(options.radius, options.suppression_radius));
    for (const std::uint32_t row : features::iss_keypoints(grid, options)) {
      keypoints.push_back(cloud->input_row(grid.original(row)));
    }
    std::sort(keypoints.begin(), keypoints.end());
    return keypoints;
  });
  return to_array(std::move(*rows));
}

/// Descriptors of some rows of the caller's array, ascending.
struct DescribedRows {
  std::vector<float> values;
  std::vector<std::int64_t> rows;
};

DescribedRows described_rows(const Cloud& cloud, const std::vector<std::uint8_t>& wanted, double radius,
                             double normal_radius, const Viewpoint& viewpoint) {
  const DescribedCloud described(cloud, radius, normal_radius, viewpoint);
  std::vector<std::uint32_t> grid_rows;
  for (std::uint32_t row = 0; row < described.grid.size(); ++row) {
    if (wanted[described.input_rows[row]] != 0) grid_rows.push_back(row);
  }
  const features::Descriptors found = features::fpfh(described.grid, grid_rows, radius);
  std::vector<std::size_t> order(found.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto input_row = [&](std::size_t k) { return described.input_rows[found.rows[k]]; };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return input_row(a) < input_row(b); });
  DescribedRows result;
  for (const std::size_t k : order) {
    result.rows.push_back(input_row(k));
    const auto first = found.values.begin() + static_cast<std::ptrdiff_t>(k * found.length);
    result.values.insert(result.values.end(), first, first + static_cast<std::ptrdiff_t>(found.length));
  }
  return result;
}

nb::tuple fpfh(ArrayLike points, double radius, double normal_radius, std::optional<ArrayLike> rows,
               const Viewpoint& viewpoint, std::optional<double> missing, std::optional<int> threads) {
  const auto cloud = shared_cloud(points, "points", missing);
  std::vector<std::uint8_t> wanted(cloud->size() + cloud->left_out(), rows ? 0 : 1);
  if (rows) {
    for (const std::uint32_t row : indices_from(*rows, "rows")) {
      if (row >= wanted.size()) {
        throw std::out_of_range("row " + std::to_string(row) + " of " + std::to_string(wanted.size()) + " points");
      }
      wanted[row] = 1;
    }
  }
  auto found = result_of(threads, [=] { return described_rows(*cloud, wanted, radius, normal_radius, viewpoint); });
  const std::size_t count = found->rows.size();
  return nb::make_tuple(to_array<Array<float, -1, 33>>(std::move(found->values), {count, 33}),
                        to_array(std::move(found->rows)));
}

using Descriptors = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

nb::tuple match(const Descriptors& source, const Descriptors& target, std::size_t best, bool mutual, double ratio,
                std::optional<int> threads) {
  if (source.shape(1) != target.shape(1)) {
    throw nb::value_error("source and target have descriptors of different lengths");
  }
  const features::MatchOptions options{best, mutual, ratio};
  // Copies: work that is left behind at Ctrl-C may outlive the caller's arrays.
  const auto copied = [](const Descriptors& from) {
    return std::make_shared<const std::vector<float>>(from.data(), from.data() + from.size());
  };
  const auto found =
      result_of(threads, [a = copied(source), b = copied(target), length = static_cast<std::size_t>(source.shape(1)),
                          options] { return features::match(*a, *b, length, options); });
  std::vector<std::int64_t> pairs;
  std::vector<float> distances;
  distances.reserve(found->size());
  for (const features::Match& m : *found) {
    pairs.insert(pairs.end(), {m.source, m.target});
    distances.push_back(m.distance);
  }
  return nb::make_tuple(to_array<Array<std::int64_t, -1, 2>>(std::move(pairs), {found->size(), 2}),
                        to_array(std::move(distances)));
}

nb::tuple nearest_neighbours(ArrayLike points, ArrayLike queries, std::size_t most, double radius,
                             std::optional<double> missing, std::optional<int> threads) {
  const auto cloud = shared_cloud(points, "points", missing);
  Points asked(queries, "queries");
  asked.widen();
  const PointSpan<double> span = asked.span<double>();
  std::vector<std::array<double, 3>> places(span.size);
  for (std::size_t k = 0; k < span.size; ++k) places[k] = {span(k, 0), span(k, 1), span(k, 2)};
  checked_radius(radius);
  const auto found = result_of(threads, [=] {
    const features::CellGrid grid(*cloud, radius);
    features::NearestLists lists = features::nearest_neighbours(grid, places, most, radius);
    for (std::uint32_t& row : lists.rows) {
      if (row != features::NearestLists::kNone) row = cloud->input_row(grid.original(row));
    }
    return lists;
  });
  std::vector<std::int64_t> rows;
  rows.reserve(found->rows.size());
  for (const std::uint32_t row : found->rows) {
    rows.push_back(row == features::NearestLists::kNone ? std::int64_t{-1} : std::int64_t{row});
  }
  return nb::make_tuple(to_array<Array<std::int64_t, -1, -1>>(std::move(rows), {places.size(), most}),
                        to_array<Array<double, -1, -1>>(std::move(found->distances), {places.size(), most}));
}

}  // namespace

void bind_features(nb::module_& module) {
  module.def("voxel_grid", &voxel_grid, nb::arg("points"), nb::arg("voxel"), nb::arg("missing").none(),
             nb::arg("threads").none());
  module.def("farthest_subset", &farthest_subset, nb::arg("points"), nb::arg("count"), nb::arg("seed"),
             nb::arg("missing").none(), nb::arg("threads").none());
  module.def("normals", &normals, nb::arg("points"), nb::arg("radius"), nb::arg("viewpoint").none(),
             nb::arg("missing").none(), nb::arg("threads").none());
  module.def("iss_keypoints", &iss_keypoints, nb::arg("points"), nb::arg("radius"), nb::arg("suppression_radius"),
             nb::arg("second_to_first"), nb::arg("third_to_second"), nb::arg("fewest_neighbours"),
             nb::arg("missing").none(), nb::arg("threads").none());
  module.def("fpfh", &fpfh, nb::arg("points"), nb::arg("radius"), nb::arg("normal_radius"), nb::arg("rows").none(),
             nb::arg("viewpoint").none(), nb::arg("missing").none(), nb::arg("threads").none());
  module.def("match", &match, nb::arg("source"), nb::arg("target"), nb::arg("best"), nb::arg("mutual"),
             nb::arg("ratio"), nb::arg("threads").none());
  module.def("nearest_neighbours", &nearest_neighbours, nb::arg("points"), nb::arg("queries"), nb::arg("most"),
             nb::arg("radius"), nb::arg("missing").none(), nb::arg("threads").none());
}

}  // namespace consimd::python
