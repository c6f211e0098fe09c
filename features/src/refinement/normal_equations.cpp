#include "refinement/normal_equations.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>

#include <consimd/kernels/pair_equations.hpp>

namespace consimd::features::detail {
namespace {

// Residuals are not told apart below the rounding of coordinates of up to 1 in single precision.
constexpr double kSmallestScale = 0x1p-23;

PairMetric metric_of(RefinementMethod method) {
  switch (method) {
    case RefinementMethod::point:
      return PairMetric::point;
    case RefinementMethod::plane:
      return PairMetric::plane;
    case RefinementMethod::gicp:
      break;
  }
  return PairMetric::gicp;
}

}  // namespace

NormalEquations& NormalEquations::operator+=(const PairEquations& part) {
  for (Eigen::Index r = 0, k = 0; r < 6; ++r) {
    for (Eigen::Index c = 0; c <= r; ++c, ++k) normal(r, c) += static_cast<double>(part.normal[k]);
    score[r] += static_cast<double>(part.score[r]);
  }
  weight += static_cast<double>(part.weight);
  spread += static_cast<double>(part.spread);
  squared_score += static_cast<double>(part.squared_score);
  slope += static_cast<double>(part.slope);
  squared_length += static_cast<double>(part.squared_length);
  pairs += part.pairs;
  return *this;
}

PairProblem pair_problem(const ClosestPairs& pairs, RefinementMethod method, const Eigen::Matrix3d& rotation,
                         const Eigen::Vector3d& centre) {
  PairProblem problem{metric_of(method), {}, {}, pairs.max_distance(), 1.0f};
  for (Eigen::Index r = 0; r < 3; ++r) {
    for (Eigen::Index c = 0; c < 3; ++c) problem.rotation[3 * r + c] = static_cast<float>(rotation(r, c));
    problem.centre[r] = static_cast<float>(centre[r]);
  }
  return problem;
}

std::vector<float> squared_residuals(const ClosestPairs& pairs, const CloudView& target, const PairProblem& problem) {
  std::vector<float> squared(pairs.size());
  tbb::parallel_for(std::size_t{0}, pairs.blocks(), [&](std::size_t b) {
    pair_residuals(target, pairs.block(b), pairs.entries(b), problem,
                   std::span(squared).subspan(b * PairBlock::kSize, pairs.entries(b)));
  });
  return squared;
}

double residual_scale(const std::vector<float>& squared, RefinementMethod method) {
  constexpr std::size_t kLooked = 4000;
  const std::size_t step = std::max<std::size_t>(1, squared.size() / kLooked);
  std::vector<float> looked;
  looked.reserve(squared.size() / step + 1);
  for (std::size_t i = 0; i < squared.size(); i += step) {
    if (squared[i] >= 0.0f) looked.push_back(squared[i]);
  }
  if (looked.empty()) return 0.0;
  const auto middle = looked.begin() + static_cast<std::ptrdiff_t>(looked.size() / 2);
  std::nth_element(looked.begin(), middle, looked.end());
  // Medians of |r| in deviations an axis: of one Gaussian component, and of the length of three.
  const double median = method == RefinementMethod::plane ? 0.6745 : 1.5382;
  return std::max(std::sqrt(static_cast<double>(*middle)) / median, kSmallestScale);
}

NormalEquations sum_of(const ClosestPairs& pairs, const CloudView& target, const PairProblem& problem) {
  std::vector<PairEquations> sums(pairs.blocks());
  tbb::parallel_for(std::size_t{0}, sums.size(), [&](std::size_t b) {
    sums[b] = pair_equations(target, pairs.block(b), pairs.entries(b), problem);
  });
  NormalEquations total;
  for (const PairEquations& sum : sums) total += sum;
  return total;
}

}  // namespace consimd::features::detail
