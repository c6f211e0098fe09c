#include "search/matrix_sample.hpp"

#include <cmath>

#include <consimd/kernels/consistency_matrix.hpp>

#include "sampling/counter_random.hpp"

namespace consimd::detail {
namespace {

constexpr std::size_t kLeastRows = 256;

}  // namespace

std::size_t rows_within(std::size_t budget_bytes, std::size_t matrices) {
  const double bits = 8.0 * static_cast<double>(budget_bytes) / static_cast<double>(matrices);
  auto rows = static_cast<std::size_t>(std::sqrt(bits));
  while (matrices * ConsistencyMatrix::memory_bytes(rows) > budget_bytes) --rows;
  return rows;
}

std::size_t least_matrix_budget(std::size_t matrices) { return matrices * ConsistencyMatrix::memory_bytes(kLeastRows); }

MatrixSample::MatrixSample(const Correspondences& correspondences, std::size_t matrices, std::size_t budget_bytes,
                           std::uint64_t seed)
    : all_(correspondences) {
  if (matrices * ConsistencyMatrix::memory_bytes(correspondences.size()) <= budget_bytes) return;
  std::size_t wanted = rows_within(budget_bytes, matrices);
  CounterRandom random(seed, RandomStage::matrix_sample, 0);
  for (std::size_t row = 0; wanted > 0; ++row) {
    if (random.below(static_cast<std::uint32_t>(correspondences.size() - row)) >= wanted) continue;
    rows_.push_back(static_cast<std::uint32_t>(row));
    --wanted;
  }
  sample_ = correspondences.subset(rows_);
}

}  // namespace consimd::detail
