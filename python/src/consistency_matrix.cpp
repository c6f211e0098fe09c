// The bit matrix of pairwise length consistency.
#include <consimd/kernels/consistency_matrix.hpp>

#include <memory>
#include <optional>
#include <string>

#include <nanobind/stl/optional.h>

#include "array_arguments.hpp"
#include "array_results.hpp"
#include "bindings.hpp"

namespace consimd::python {
namespace {

void make_matrix(ConsistencyMatrix* self, const SharedCorrespondences& c, double bound,
                 std::optional<double> separation, std::optional<double> ratio_bound) {
  if (separation && ratio_bound) throw nb::value_error("separation and ratio_bound exclude each other");
  ConsistencyMatrix matrix;
  {
    const nb::gil_scoped_release unlocked;
    if (separation) {
      matrix.compute_separated(*c.rows, bound, *separation);
    } else if (ratio_bound) {
      matrix.compute_ratio(*c.rows, bound, *ratio_bound);
    } else {
      matrix.compute(*c.rows, bound);
    }
  }
  new (self) ConsistencyMatrix(std::move(matrix));
}

Array<std::uint32_t, -1> bound_and_popcount_rows(const ConsistencyMatrix& matrix, ArrayLike set_like,
                                                 ArrayLike rows_like) {
  const std::vector<std::uint64_t> set = words_from(set_like, "set", matrix.words());
  const std::vector<std::uint32_t> rows = indices_from(rows_like, "rows");
  for (const std::uint32_t row : rows) {
    if (row >= matrix.size()) {
      throw nb::index_error(
          ("rows holds " + std::to_string(row) + ", the matrix has " + std::to_string(matrix.size())).c_str());
    }
  }
  std::vector<std::uint32_t> counts(rows.size());
  {
    const nb::gil_scoped_release unlocked;
    and_popcount_rows(matrix, set, rows, counts);
  }
  return to_array(std::move(counts));
}

Array<float, -1> bound_masked_row_sums(const ConsistencyMatrix& matrix, ArrayLike values_like, std::size_t first_row,
                                       std::optional<std::size_t> row_count) {
  std::vector<float> values = floats_from(values_like, "values", matrix.size());
  values.resize(matrix.words() * kBlock);
  const std::size_t left = first_row < matrix.size() ? matrix.size() - first_row : 0;
  std::vector<float> sums(row_count.value_or(left));
  if (sums.size() > left) {
    throw nb::index_error(("rows " + std::to_string(first_row) + " to " + std::to_string(first_row + sums.size()) +
                           " of a matrix of " + std::to_string(matrix.size()))
                              .c_str());
  }
  {
    const nb::gil_scoped_release unlocked;
    masked_row_sums(matrix, first_row, values, sums);
  }
  return to_array(std::move(sums));
}

}  // namespace

void bind_consistency_matrix(nb::module_& module) {
  nb::class_<ConsistencyMatrix>(module, "ConsistencyMatrix",
                                "Which correspondences agree pairwise in length: an N x N symmetric matrix of bits.")
      .def("__init__", &make_matrix, nb::arg("correspondences"), nb::arg("bound"), nb::arg("separation") = nb::none(),
           nb::kw_only(), nb::arg("ratio_bound") = nb::none(),
           "bound: largest difference of two lengths, caller's unit, > 0. With a separation (caller's unit, > 0) also\n"
           "|p_i - p_j| + |q_i - q_j| > separation, so short pairs and the diagonal are not set. With a\n"
           "ratio_bound in (0, 1), of the squared lengths a and b, also |b - a| < ratio_bound (a + b); nor is the\n"
           "diagonal set then. Takes memory_bytes(N): 1.1 MB for 3000 correspondences, 12.6 MB for 10 000.")
      .def_static("memory_bytes", &ConsistencyMatrix::memory_bytes, nb::arg("correspondences"),
                  "Memory of the matrix of so many correspondences.")
      .def("__len__", &ConsistencyMatrix::size)
      .def("__repr__",
           [](const ConsistencyMatrix& self) {
             return "<consimd.kernels.ConsistencyMatrix: " + std::to_string(self.size()) + " rows>";
           })
      .def_prop_ro(
          "bits",
          [](nb::handle self) {
            const auto& matrix = nb::cast<const ConsistencyMatrix&>(self);
            return View<std::uint64_t, -1, -1>(matrix.data(), {matrix.size(), matrix.words()}, self);
          },
          "(N, words) uint64, a read-only view: bit j % 64 of word j // 64 of row i tells whether i and j agree.")
      .def_prop_ro(
          "degrees",
          [](nb::handle self) {
            const auto& matrix = nb::cast<const ConsistencyMatrix&>(self);
            return View<std::uint32_t, -1>(matrix.degrees().data(), {matrix.size()}, self);
          },
          "(N,) uint32, a read-only view: number of ones in each row, the diagonal included.");
  module.def(
      "popcount", [](ArrayLike bits) { return popcount(words_from(bits, "bits")); }, nb::arg("bits"),
      "Number of bits set in an array of uint64 words.");
  module.def(
      "and_popcount",
      [](ArrayLike a_like, ArrayLike b_like) {
        const std::vector<std::uint64_t> a = words_from(a_like, "a");
        return and_popcount(a, words_from(b_like, "b", a.size()));
      },
      nb::arg("a"), nb::arg("b"), "Number of bits set in both of two equally long arrays of uint64 words.");
  module.def("and_popcount_rows", &bound_and_popcount_rows, nb::arg("matrix"), nb::arg("set"), nb::arg("rows"),
             "For each of the rows, (R,), the number of bits set in both it and `set`, (words,) uint64. With\n"
             "set = matrix.bits[i]: common neighbours of i and each row. Returns (R,) uint32.");
  module.def(
      "masked_row_sums", &bound_masked_row_sums, nb::arg("matrix"), nb::arg("values"), nb::arg("first_row") = 0,
      nb::arg("row_count") = nb::none(),
      "Rows of the product of the matrix and a vector: sums of values[j] over the ones j of each row.\n"
      "values: (N,), used in single precision. Returns (row_count,) float32, by default all rows from first_row.");
}

}  // namespace consimd::python
