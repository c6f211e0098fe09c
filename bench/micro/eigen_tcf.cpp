#include "eigen_tcf.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <random>
#include <vector>

#include "eigen_geometry.hpp"

namespace consimd::bench::eigen {
namespace {

using Rows = std::vector<std::uint32_t>;
using Random = std::mt19937_64;

std::uint32_t draw(const Rows& rows, Random& random) {
  return rows[std::uniform_int_distribution<std::size_t>(0, rows.size() - 1)(random)];
}

/// The largest set of rows that hypotheses of `sample` of the `population` correspondences give.
template <typename Hypothesis>
Rows ransac(const EigenTcfOptions& options, std::size_t population, int sample, const Hypothesis& set_of_next) {
  Rows best, set;
  double needed = options.max_iterations;
  for (int i = 0; i <= needed && i < options.max_iterations; ++i) {
    set_of_next(&set);
    if (set.empty() || set.size() < best.size()) continue;
    best.swap(set);
    const double inliers = static_cast<double>(best.size()) / static_cast<double>(population);
    needed = std::ceil(std::log(1.0 - options.confidence) / std::log1p(-std::pow(inliers, sample)));
  }
  return best;
}

EigenCloud part(const EigenCloud& c, const Rows& rows) {
  EigenCloud selected;
  for (const std::uint32_t row : rows) {
    selected.source.push_back(c.source[row]);
    selected.target.push_back(c.target[row]);
  }
  return selected;
}

void prune(const EigenCloud& c, double bound, Rows* set) {
  const std::size_t size = set->size();
  std::vector<char> matrix;
  consistency_matrix(part(c, *set), bound, &matrix);
  Rows kept(size), degree(size);
  std::iota(kept.begin(), kept.end(), 0U);
  for (int round = 0; round < 50; ++round) {
    double ones = 0.0;
    for (const std::uint32_t i : kept) {
      degree[i] = 0;
      for (const std::uint32_t j : kept) degree[i] += matrix[i * size + j] != 0 ? 1 : 0;
      ones += degree[i];
    }
    const auto leave = static_cast<std::size_t>(std::ceil(std::sqrt(ones)));
    const std::size_t drop = kept.size() - leave;
    std::stable_sort(kept.begin(), kept.end(), [&](auto i, auto j) { return degree[i] > degree[j]; });
    kept.resize(leave);
    if (drop < 5) break;
  }
  std::sort(kept.begin(), kept.end());
  for (std::size_t k = 0; k < kept.size(); ++k) (*set)[k] = (*set)[kept[k]];
  set->resize(kept.size());
}

Rows one_point_ransac(const EigenCloud& c, const EigenTcfOptions& options, Random& random) {
  const double bound = 2.0 * options.noise_bound;
  std::uniform_int_distribution<std::uint32_t> seed(0, static_cast<std::uint32_t>(c.source.size() - 1));
  return ransac(options, c.source.size(), 1, [&](Rows* set) {
    length_set(c, seed(random), bound, set);
    if (options.prune) prune(c, bound, set);
  });
}

Rows two_point_ransac(const EigenCloud& c, const Rows& one, const EigenTcfOptions& options, Random& random) {
  if (one.size() < 2) return {};
  const double bound = 2.0 * options.noise_bound;
  return ransac(options, one.size(), 2, [&](Rows* set) {
    const std::uint32_t i = draw(one, random);
    std::uint32_t j = i;
    while (j == i) j = draw(one, random);
    set->clear();
    for (const std::uint32_t m : one) {
      if (length_consistent(c, i, m, bound) && length_consistent(c, j, m, bound) &&
          angle_consistent(c, i, j, m, bound)) {
        set->push_back(m);
      }
    }
  });
}

Rows three_point_ransac(const EigenCloud& c, const Rows& two, const EigenTcfOptions& options, Random& random) {
  if (two.size() < 3) return {};
  return ransac(options, two.size(), 3, [&](Rows* set) {
    std::uint32_t rows[3] = {draw(two, random), draw(two, random), draw(two, random)};
    while (rows[1] == rows[0]) rows[1] = draw(two, random);
    while (rows[2] == rows[0] || rows[2] == rows[1]) rows[2] = draw(two, random);
    const EigenPose pose = three_point_fit(c, rows);
    set->clear();
    for (const std::uint32_t m : two) {
      if (residual(c, pose, m) < options.noise_bound) set->push_back(m);
    }
  });
}

EigenPose weighted_fit(const EigenCloud& c, const Rows& rows, const std::vector<double>& weights) {
  EigenMoments m;
  for (std::size_t k = 0; k < rows.size(); ++k) add(c, rows[k], weights[k], &m);
  return kabsch(m.cross - m.target * m.source.transpose() / m.weight, m.source / m.weight, m.target / m.weight);
}

/// Algorithm 3, with its constants.
EigenPose sa_cauchy_irls(const EigenCloud& c, const Rows& three) {
  std::vector<double> weights(three.size(), 1.0);
  EigenPose pose = weighted_fit(c, three, weights);
  double scale = 0.0;
  for (const std::uint32_t row : three) scale = std::max(scale, residual(c, pose, row));
  double cost = 0.0;
  for (int round = 0; round < 100; ++round) {
    pose = weighted_fit(c, three, weights);
    const double last_cost = cost;
    cost = 0.0;
    for (std::size_t k = 0; k < three.size(); ++k) {
      const double e = residual(c, pose, three[k]);
      weights[k] = e < 3.0 * scale ? scale * scale / (scale * scale + e * e) : 0.0;
      cost += weights[k] * e * e;
    }
    scale /= 1.3;
    if (std::abs(cost - last_cost) < 0.01 || scale < 1.0) break;
  }
  return pose;
}

}  // namespace

std::optional<EigenPose> register_tcf(const EigenCloud& c, const EigenTcfOptions& options) {
  Random random(options.seed);
  const Rows one = one_point_ransac(c, options, random);
  const Rows two = two_point_ransac(c, one, options, random);
  const Rows three = three_point_ransac(c, two, options, random);
  if (three.size() < 3) return std::nullopt;
  return sa_cauchy_irls(c, three);
}

}  // namespace consimd::bench::eigen
