#include <consimd/kernels/pair_equations.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "../dispatch.hpp"
#include "../kernel_arguments.hpp"
#include "cloud_arguments.hpp"

namespace consimd {
namespace {

void require_entries(std::size_t n) {
  if (n <= PairBlock::kSize) return;
  throw std::invalid_argument("n is " + std::to_string(n) + ", expected at most " + std::to_string(PairBlock::kSize));
}

void check(const CloudView& target, const PairBlock& block, std::size_t n, const PairProblem& problem) {
  require_entries(n);
  if (problem.metric != PairMetric::point && !target.has_normals()) {
    throw std::invalid_argument("the target has no normals");
  }
  const std::uint32_t largest = n == 0 ? 0 : *std::max_element(block.rows, block.rows + n);
  if (largest <= target.size()) return;
  throw std::out_of_range("row " + std::to_string(largest) + " of " + std::to_string(target.size()) + " points");
}

}  // namespace

void move_pairs(PairBlock& block, std::size_t n, const WorkingMotion& motion,
                std::span<std::uint64_t, PairBlock::kSize / 64> stale) {
  require_entries(n);
  detail::active_table().clouds.move_pairs(block, n, motion, stale.data());
}

void pair_residuals(const CloudView& target, const PairBlock& block, std::size_t n, const PairProblem& problem,
                    std::span<float> squared) {
  check(target, block, n, problem);
  detail::require_size("squared", squared.size(), n);
  detail::active_table().clouds.pair_residuals(detail::raw_points(target), block, n, problem, squared.data());
}

PairEquations pair_equations(const CloudView& target, const PairBlock& block, std::size_t n,
                             const PairProblem& problem) {
  check(target, block, n, problem);
  // The square of less could be too small for single precision.
  if (!(problem.scale >= 0x1p-40f)) {
    throw std::invalid_argument("scale is " + std::to_string(problem.scale) + ", expected 2^-40 or more");
  }
  PairEquations equations;
  detail::active_table().clouds.pair_equations(detail::raw_points(target), block, n, problem, equations);
  return equations;
}

}  // namespace consimd
