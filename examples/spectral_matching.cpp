// A solver of one's own on consimd's consistency matrix: spectral matching in 40 lines.
// M. Leordeanu, M. Hebert, "A Spectral Technique for Correspondence Problems Using Pairwise Constraints", ICCV 2005.
//
// Two correspondences are adjacent when the lengths between their points agree in both clouds. Inliers all agree with
// one another, outliers by chance only: the principal eigenvector of the adjacency matrix is large on the inliers. The
// solver takes correspondences by falling entry, each if it agrees with all that were taken before.
//
// Before: adjacency lists filled by two nested loops. After: consimd::ConsistencyMatrix, a bit an entry, and its
// product with a vector. The solver is one template, so nothing else differs.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include <consimd/kernels/consistency_matrix.hpp>

#include "before_and_after.hpp"

namespace {

using consimd::RigidTransform;
using consimd::synth::Problem;

Eigen::Map<const Eigen::Matrix3Xd> columns(const std::vector<double>& points) {
  return {points.data(), 3, static_cast<Eigen::Index>(points.size() / 3)};
}

// --- Before: lists of neighbours. The fastest of what is quickly written: half the time of a dense Eigen matrix.
class LoopGraph {
 public:
  LoopGraph(const Problem& problem, double bound) : neighbours_(problem.size()) {
    const auto p = columns(problem.source);
    const auto q = columns(problem.target);
    for (std::uint32_t i = 0; i < size(); ++i) {
      neighbours_[i].push_back(i);
      for (std::uint32_t j = i + 1; j < size(); ++j) {
        const double source_length = (p.col(i) - p.col(j)).norm();
        const double target_length = (q.col(i) - q.col(j)).norm();
        if (std::abs(source_length - target_length) >= bound) continue;
        neighbours_[i].push_back(j);
        neighbours_[j].push_back(i);
      }
    }
  }
  [[nodiscard]] std::size_t size() const { return neighbours_.size(); }
  template <typename Visitor>
  void visit_neighbours(std::uint32_t i, Visitor visit) const {
    for (const std::uint32_t j : neighbours_[i]) visit(j);
  }
  [[nodiscard]] std::size_t entries() const {
    return std::accumulate(neighbours_.begin(), neighbours_.end(), std::size_t{0},
                           [](std::size_t sum, const auto& list) { return sum + list.size(); });
  }
  void multiply(const Eigen::VectorXf& values, Eigen::VectorXf& sums) const {
    for (std::size_t i = 0; i < size(); ++i) {
      float sum = 0.0f;
      for (const std::uint32_t j : neighbours_[i]) sum += values[j];
      sums[static_cast<Eigen::Index>(i)] = sum;
    }
  }

 private:
  std::vector<std::vector<std::uint32_t>> neighbours_;
};

// --- After: the bit matrix.
class KernelGraph {
 public:
  KernelGraph(const Problem& problem, double bound) { matrix_.compute(problem.correspondences(), bound); }
  [[nodiscard]] std::size_t size() const { return matrix_.size(); }
  template <typename Visitor>
  void visit_neighbours(std::uint32_t i, Visitor visit) const {
    for (std::size_t word = 0; word < matrix_.words(); ++word) {
      for (std::uint64_t rest = matrix_.row(i)[word]; rest != 0; rest &= rest - 1) {
        visit(static_cast<std::uint32_t>(64 * word) + static_cast<std::uint32_t>(std::countr_zero(rest)));
      }
    }
  }
  [[nodiscard]] std::size_t entries() const {
    return std::accumulate(matrix_.degrees().begin(), matrix_.degrees().end(), std::size_t{0});
  }
  /// The kernel reads whole 64-bit words, so `values` is padded to a multiple of 64.
  void multiply(const Eigen::VectorXf& values, Eigen::VectorXf& sums) const {
    padded_.assign(matrix_.words() * 64, 0.0f);
    std::copy(values.begin(), values.end(), padded_.begin());
    consimd::masked_row_sums(matrix_, 0, padded_, {sums.data(), size()});
  }

 private:
  consimd::ConsistencyMatrix matrix_;
  mutable std::vector<float> padded_;
};

// --- The solver, the same for both.
template <typename Graph>
std::vector<std::uint32_t> spectral_matching(const Graph& graph) {
  constexpr int kPowerIterations = 30;
  const auto size = static_cast<Eigen::Index>(graph.size());
  Eigen::VectorXf eigenvector = Eigen::VectorXf::Ones(size), product(size);
  for (int iteration = 0; iteration < kPowerIterations; ++iteration) {
    graph.multiply(eigenvector, product);
    eigenvector = product.normalized();
  }
  std::vector<std::uint32_t> order(graph.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return eigenvector[i] > eigenvector[j]; });

  std::vector<std::uint32_t> taken, agreements(graph.size(), 0);  // with those taken
  for (const std::uint32_t i : order) {
    if (agreements[i] != taken.size()) continue;
    taken.push_back(i);
    graph.visit_neighbours(i, [&](std::uint32_t j) { ++agreements[j]; });
  }
  return taken;
}

struct Times {
  std::vector<double> matrix, solver;
};

template <typename Graph>
example::Method measured(const char* name, const example::Input& input, Times& times, std::size_t& entries) {
  example::Method method{name, {}};
  for (std::size_t run = 0; run < input.runs; ++run) {
    std::optional<Graph> graph;
    std::vector<std::uint32_t> matches;
    // Two inliers, each within the noise bound of the true pose, differ by at most two bounds in length.
    times.matrix.push_back(example::seconds_of([&] { graph.emplace(input.problem, 2.0 * input.noise_bound); }));
    RigidTransform pose;
    times.solver.push_back(example::seconds_of([&] {
      matches = spectral_matching(*graph);
      pose = example::refit(input, example::least_squares_pose(input.problem, matches));
    }));
    entries = graph->entries();
    method.runs.push_back({pose, times.matrix.back() + times.solver.back()});
  }
  return method;
}

}  // namespace

int main(int argc, char** argv) {
  const example::Input input = example::read_input(
      argc, argv, "Spectral matching with a consistency matrix from nested loops, then from consimd. One thread.",
      {.correspondences = 3000, .outlier_ratio = 0.9, .sigma = 1.0});

  Times before, after;
  std::size_t entries_before = 0, entries_after = 0;
  const example::Method methods[] = {
      measured<LoopGraph>("nested loops", input, before, entries_before),
      measured<KernelGraph>("consimd::ConsistencyMatrix", input, after, entries_after),
  };
  example::print_table(input, methods);
  const auto print_part = [](const char* part, const std::vector<double>& loops, const std::vector<double>& kernels) {
    const double loops_ms = 1e3 * example::median(loops), kernels_ms = 1e3 * example::median(kernels);
    std::printf("%-8s %9.2f ms -> %6.2f ms, %5.1fx\n", part, loops_ms, kernels_ms, loops_ms / kernels_ms);
  };
  print_part("matrix", before.matrix, after.matrix);
  print_part("solver", before.solver, after.solver);

  // Single precision may decide a length at the very bound otherwise: a few entries in a million.
  const double ratio = static_cast<double>(entries_after) / static_cast<double>(entries_before);
  bool fine = example::check(std::abs(ratio - 1.0) < 1e-4, "both matrices have as many ones, to 1 in 10 000");
  fine &= example::check(all_good(input, methods[0]) && all_good(input, methods[1]), "both poses are good");
  return fine ? 0 : 1;
}
