#include "refinement/refined_covariance.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>

#include <consimd/kernels/pair_equations.hpp>

namespace consimd::features::detail {
namespace {

// Places are halved three times along each of as many axes on the way to 64 groups, and once on the way to eight.
constexpr int kHalvings = 6;
constexpr std::size_t kGroups = std::size_t{1} << kHalvings;
// What the mean square of eight groups' scores exceeds once in fifty times if residuals are independent: they have 42
// freedoms, 6 of 48 being spent by the fit, and 64.2 / 42 is that quantile of a chi-square variable over its freedoms.
constexpr double kByChance = 1.53;

/// Sums over a group of pairs that lie side by side.
struct Group {
  Vector6d score = Vector6d::Zero();
  Matrix6d normal = Matrix6d::Zero();
};

struct Place {
  float point[3];
  std::uint32_t entry;
};

/// Halves the places across the axis along which they reach furthest, again and again; leaves lie one after the other.
void halve(std::vector<Place>& places, std::size_t begin, std::size_t end, int halvings,
           std::vector<std::size_t>& ends) {
  if (halvings == 0) {
    ends.push_back(end);
    return;
  }
  std::size_t axis = 0;
  float longest = -1.0f;
  for (std::size_t c = 0; c < 3; ++c) {
    float low = places[begin].point[c], high = low;
    for (std::size_t k = begin; k < end; ++k) {
      low = std::min(low, places[k].point[c]);
      high = std::max(high, places[k].point[c]);
    }
    if (high - low > longest) {
      longest = high - low;
      axis = c;
    }
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t k) { return places.begin() + static_cast<std::ptrdiff_t>(k); };
  // Equal ones by their number, so that the halves are the same with any library.
  std::nth_element(at(begin), at(middle), at(end), [axis](const Place& a, const Place& b) {
    return a.point[axis] < b.point[axis] || (a.point[axis] == b.point[axis] && a.entry < b.entry);
  });
  halve(places, begin, middle, halvings - 1, ends);
  halve(places, middle, end, halvings - 1, ends);
}

/// Over these entries alone.
NormalEquations sum_of(const ClosestPairs& pairs, const CloudView& target, const PairProblem& problem,
                       std::span<const Place> places) {
  NormalEquations sum;
  PairBlock chosen;
  for (std::size_t begin = 0; begin < places.size(); begin += PairBlock::kSize) {
    const std::size_t count = std::min(PairBlock::kSize, places.size() - begin);
    for (std::size_t k = 0; k < count; ++k) {
      const Place& place = places[begin + k];
      const PairBlock& block = pairs.block(place.entry / PairBlock::kSize);
      const std::size_t entry = place.entry % PairBlock::kSize;
      for (std::size_t c = 0; c < 3; ++c) {
        chosen.points[c][k] = place.point[c];
        chosen.normals[c][k] = block.normals[c][entry];
      }
      chosen.rows[k] = block.rows[entry];
    }
    sum += pair_equations(target, chosen, count, problem);
  }
  return sum;
}

/// Mean square of the groups' scores, whitened, over that of independent residuals.
double mean_square(const std::vector<Group>& groups, const Eigen::LLT<Matrix6d>& factors, double variance) {
  double squares = 0.0;
  double spent = 0.0;  // of the six freedoms of each group by the fit to all
  for (const Group& group : groups) {
    squares += group.score.dot(factors.solve(group.score));
    const Matrix6d share = factors.solve(group.normal);
    spent += share.cwiseProduct(share.transpose()).sum();
  }
  return squares / (variance * std::max(6.0 - spent, 1.0));
}

}  // namespace

double shared_error_factor(const ClosestPairs& pairs, const CloudView& target, const PairProblem& problem,
                           std::span<const float> squared, const NormalEquations& sums) {
  std::vector<Place> places;
  places.reserve(sums.pairs);
  for (std::uint32_t i = 0; i < pairs.size(); ++i) {
    if (!(squared[i] >= 0.0f)) continue;
    const auto& points = pairs.block(i / PairBlock::kSize).points;
    const std::size_t k = i % PairBlock::kSize;
    places.push_back({{points[0][k], points[1][k], points[2][k]}, i});
  }
  // Groups of fewer pairs than a pose has freedoms tell nothing.
  if (places.size() < 6 * kGroups) return 1.0;
  std::vector<std::size_t> ends;
  halve(places, 0, places.size(), kHalvings, ends);
  std::vector<Group> groups(ends.size());
  for (std::size_t g = 0, begin = 0; g < groups.size(); begin = ends[g++]) {
    const NormalEquations part = sum_of(pairs, target, problem, std::span(places).subspan(begin, ends[g] - begin));
    groups[g] = {part.score, Matrix6d(part.normal.selfadjointView<Eigen::Lower>())};
  }
  const Eigen::LLT<Matrix6d> factors(sums.normal);  // reads the lower triangle
  if (factors.info() != Eigen::Success) return 1.0;
  const double variance = sums.squared_score / sums.weight;
  const auto merge = [&groups] {
    for (std::size_t g = 0; g < groups.size() / 2; ++g) {
      groups[g].score = groups[2 * g].score + groups[2 * g + 1].score;
      groups[g].normal = groups[2 * g].normal + groups[2 * g + 1].normal;
    }
    groups.resize(groups.size() / 2);
  };
  const double of_many = std::max(mean_square(groups, factors, variance), 1.0);
  for (int halving = 0; halving < kHalvings / 2; ++halving) merge();
  const double of_few = mean_square(groups, factors, variance);
  if (of_few < kByChance) return 1.0;
  return 1.0 + static_cast<double>(groups.size()) * std::max(of_few - 1.0, 0.0) * std::max(1.0, of_few / of_many);
}

Matrix6d independent_covariance(const NormalEquations& sums) {
  const Matrix6d whole = sums.normal.selfadjointView<Eigen::Lower>();
  const double slope = std::max(sums.slope / sums.weight, 0.1);
  return sums.squared_score / sums.weight / (slope * slope) * whole.ldlt().solve(Matrix6d::Identity());
}

}  // namespace consimd::features::detail
