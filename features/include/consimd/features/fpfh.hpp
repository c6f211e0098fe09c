// Fast point feature histograms.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// Descriptors of some points of a cloud: values[length * k + c] is component c of the descriptor of rows[k].
struct Descriptors {
  std::size_t length = 0;
  std::vector<std::uint32_t> rows;
  std::vector<float> values;

  [[nodiscard]] std::size_t size() const noexcept { return rows.size(); }
};

/// FPFH (Rusu, Blodow, Beetz, ICRA 2009) of the points `rows`: three histograms of 11 bins over the pair features (see
/// pair_features.hpp), each the mean of the neighbours' simplified histograms (SPFH) weighted with one over their
/// squared distances and brought to a sum of 100, as PCL has it. A neighbourhood is the points within `radius`
/// (caller's unit, at most the grid's cell). SPFHs are made only of points that an FPFH needs. A point without a
/// neighbour that has a normal gets no descriptor: it is missing in the result. rows: of grid.cloud(), ascending. In
/// parallel; the same for any number of threads. Memory: 192 bytes for each point whose SPFH is needed. Throws
/// std::invalid_argument where the grid has no normals, on a bad radius or rows that do not ascend, std::out_of_range
/// on a bad row.
[[nodiscard]] Descriptors fpfh(const CellGrid& grid, std::span<const std::uint32_t> rows, double radius);

}  // namespace features
}  // namespace consimd
