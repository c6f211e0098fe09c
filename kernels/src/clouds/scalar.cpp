// The specification of the kernels on clouds and descriptors, as plain loops; see ../scalar.cpp. That of the kernels on
// pairs of points is in scalar_pair_equations.cpp.
#include <cmath>

#include "../scalar_terms.hpp"
#include "cloud_kernels.hpp"

namespace consimd::detail::scalar {

std::size_t neighbours_within(const RawPoints& cloud, const float query[3], const PointRun* runs, std::size_t n,
                              float radius, std::uint32_t* indices, float* squared) {
  const Point q{query[0], query[1], query[2]};
  std::size_t count = 0;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::uint32_t i = runs[r].first; i < runs[r].last; ++i) {
      const Point offset = at(cloud.points, i) - q;
      const float distance = dot(offset, offset);
      if (!(distance <= radius * radius)) continue;
      indices[count] = i;
      squared[count] = distance;
      ++count;
    }
  }
  return count;
}

std::size_t nearest_within(const RawPoints& cloud, const float query[3], const PointRun* runs, std::size_t n,
                           float radius, std::size_t most, std::uint32_t* indices, float* squared) {
  const Point q{query[0], query[1], query[2]};
  std::size_t count = 0;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::uint32_t i = runs[r].first; i < runs[r].last; ++i) {
      const Point offset = at(cloud.points, i) - q;
      const float distance = dot(offset, offset);
      if (!(distance <= radius * radius)) continue;
      const auto nearer = [&](std::size_t rank) {
        return distance < squared[rank] || (distance == squared[rank] && i < indices[rank]);
      };
      if (count == most && !nearer(most - 1)) continue;
      std::size_t rank = count < most ? count++ : most - 1;
      for (; rank > 0 && nearer(rank - 1); --rank) {
        squared[rank] = squared[rank - 1];
        indices[rank] = indices[rank - 1];
      }
      squared[rank] = distance;
      indices[rank] = i;
    }
  }
  return count;
}

void neighbourhood_scatter(const RawPoints& cloud, const float centre[3], const std::uint32_t* indices, std::size_t n,
                           float unit, float scatter[6]) {
  const Point c{centre[0], centre[1], centre[2]};
  const float shrink = 1.0f / unit;
  InterleavedSum x, y, z, xx, xy, xz, yy, yz, zz;
  for (std::size_t j = 0; j < n; ++j) {
    const Point d = shrink * (at(cloud.points, indices[j]) - c);
    x.add(j, d.x);
    y.add(j, d.y);
    z.add(j, d.z);
    xx.add(j, d.x * d.x);
    xy.add(j, d.x * d.y);
    xz.add(j, d.x * d.z);
    yy.add(j, d.y * d.y);
    yz.add(j, d.y * d.z);
    zz.add(j, d.z * d.z);
  }
  const float share = 1.0f / static_cast<float>(n);
  const Point sum{x.total(), y.total(), z.total()};
  const Point mean = share * sum;
  scatter[0] = xx.total() - sum.x * mean.x;
  scatter[1] = xy.total() - sum.x * mean.y;
  scatter[2] = xz.total() - sum.x * mean.z;
  scatter[3] = yy.total() - sum.y * mean.y;
  scatter[4] = yz.total() - sum.y * mean.z;
  scatter[5] = zz.total() - sum.z * mean.z;
}

// ---- Principal axes: Jacobi's rotations, each of which makes one entry beside the diagonal zero.

namespace {

/// A symmetric matrix while it is made diagonal, and the columns of the rotation that does it.
struct Diagonalisation {
  float diagonal[3];
  float beside[3];  ///< beside[k]: the entry in the rows other than k
  float columns[3][3];

  /// Makes entry (p, q) zero; r is the third row.
  void rotate(int p, int q, int r) {
    const float e = beside[r] + beside[r];
    const float d = diagonal[q] - diagonal[p];
    const float h = std::fabs(d) + std::sqrt(d * d + e * e);
    const float t = h > 0.0f ? (d < 0.0f ? 0.0f - e : e) / h : 0.0f;
    const float c = 1.0f / std::sqrt(t * t + 1.0f);
    const float s = t * c;
    diagonal[p] = diagonal[p] - t * beside[r];
    diagonal[q] = diagonal[q] + t * beside[r];
    beside[r] = 0.0f;
    const float rp = beside[q];
    const float rq = beside[p];
    beside[q] = c * rp - s * rq;
    beside[p] = s * rp + c * rq;
    for (int k = 0; k < 3; ++k) {
      const float of_p = columns[p][k];
      const float of_q = columns[q][k];
      columns[p][k] = c * of_p - s * of_q;
      columns[q][k] = s * of_p + c * of_q;
    }
  }
};

}  // namespace

void principal_axes(const float* const scatter[6], std::size_t n, float* const axes[3], float* const values[3]) {
  constexpr int kSweeps = 4;
  for (std::size_t i = 0; i < n; ++i) {
    Diagonalisation m{{scatter[0][i], scatter[3][i], scatter[5][i]},
                      {scatter[4][i], scatter[2][i], scatter[1][i]},
                      {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}}};
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      m.rotate(0, 1, 2);
      m.rotate(0, 2, 1);
      m.rotate(1, 2, 0);
    }
    const float* d = m.diagonal;
    const bool second_below_first = d[1] < d[0];
    const float low = second_below_first ? d[1] : d[0];
    const float high = second_below_first ? d[0] : d[1];
    const bool third_lowest = d[2] < low;
    for (int k = 0; k < 3; ++k) {
      axes[k][i] = third_lowest ? m.columns[2][k] : second_below_first ? m.columns[1][k] : m.columns[0][k];
    }
    const bool third_highest = high < d[2];
    values[0][i] = third_lowest ? d[2] : low;
    values[1][i] = third_lowest ? low : third_highest ? high : d[2];
    values[2][i] = third_highest ? d[2] : high;
  }
}

// ---- Pair features.

void pair_feature_counts(const RawPoints& cloud, std::uint32_t point, const std::uint32_t* indices, std::size_t n,
                         std::uint32_t* counts) {
  for (std::size_t bin = 0; bin < 3 * kFeatureBins; ++bin) counts[bin] = 0;
  const Point p1 = at(cloud.points, point);
  const Point n1 = at(cloud.normals, point);
  for (std::size_t j = 0; j < n; ++j) {
    const Point d = at(cloud.points, indices[j]) - p1;
    const Point n2 = at(cloud.normals, indices[j]);
    const float squared_length = dot(d, d);
    const float along1 = dot(n1, d);
    const float along2 = dot(n2, d);
    const float cosine = dot(n1, n2);
    const float volume = dot(cross(n1, n2), d);
    // The end whose normal is nearer to the line is the source, whose frame the features are measured in.
    const bool swapped = std::fabs(along1) < std::fabs(along2);
    const float along_source = swapped ? 0.0f - along2 : along1;
    const float along_target = swapped ? 0.0f - along1 : along2;
    const float squared_v = squared_length - along_source * along_source;
    const bool has_normals = cosine == cosine;  // NOLINT(misc-redundant-expression): not NaN
    if (!(squared_length > 0.0f) || !(squared_v > 0.0f) || !has_normals) continue;
    const float turned = along_target - along_source * cosine;
    const float reach = cosine * std::sqrt(squared_v);

    const float of_turned = std::fabs(turned);
    const float squared_volume = volume * volume;
    const float squared_along = along_source * along_source;
    std::size_t steps[3] = {};
    for (std::size_t& b = steps[0]; b < 5 && kSines[b] * reach <= kCosines[b] * of_turned;) ++b;
    for (std::size_t& b = steps[1]; b < 5 && kSquaredShares[b] * squared_v <= squared_volume;) ++b;
    for (std::size_t& b = steps[2]; b < 5 && kSquaredShares[b] * squared_length <= squared_along;) ++b;
    const float signs[3] = {turned, volume, along_source};
    for (std::size_t f = 0; f < 3; ++f) {
      ++counts[f * kFeatureBins + (signs[f] < 0.0f ? 5 - steps[f] : 5 + steps[f])];
    }
  }
}

void weighted_histogram_sum(const float* histograms, const std::uint32_t* rows, const float* squared, std::size_t n,
                            float* sum) {
  for (int bin = 0; bin < 48; ++bin) sum[bin] = 0.0f;
  for (std::size_t j = 0; j < n; ++j) {
    if (!(squared[j] > 0.0f)) continue;
    const float weight = 1.0f / squared[j];
    for (std::size_t bin = 0; bin < 48; ++bin) sum[bin] = sum[bin] + weight * histograms[48 * rows[j] + bin];
  }
}

// ---- Matches.

namespace {

/// Enters a match before those that are farther, or as far and of a higher number.
void enter(const RawMatches& best, std::size_t k, std::size_t i, std::int32_t distance, std::int32_t number) {
  const auto comes_first = [&](std::size_t rank) {
    const std::size_t at = rank * best.stride + i;
    return distance < best.distances[at] || (distance == best.distances[at] && number < best.numbers[at]);
  };
  std::size_t rank = k - 1;
  if (!comes_first(rank)) return;
  for (; rank > 0 && comes_first(rank - 1); --rank) {
    best.distances[rank * best.stride + i] = best.distances[(rank - 1) * best.stride + i];
    best.numbers[rank * best.stride + i] = best.numbers[(rank - 1) * best.stride + i];
  }
  best.distances[rank * best.stride + i] = distance;
  best.numbers[rank * best.stride + i] = number;
}

}  // namespace

void best_matches(const RawDescriptors& queries, const QueryGroups& groups, const RawDescriptors& targets,
                  std::size_t k, const RawMatches& of_queries, const RawMatches& of_targets,
                  const MatchScratch& /*unused*/) {
  const std::size_t length = 2 * queries.pairs;
  for (std::size_t g = 0; g < groups.count; ++g) {
    const std::size_t first = groups.first + g * groups.step;
    for (std::size_t i = first; i < queries.size && i < first + kQueryGroup; ++i) {
      for (std::size_t j = 0; j < targets.size; ++j) {
        std::int32_t product = 0;
        for (std::size_t c = 0; c < length; ++c) {
          product += std::int32_t{queries.rows[i * length + c]} * std::int32_t{targets.rows[j * length + c]};
        }
        const std::int32_t distance = queries.squared_norms[i] + targets.squared_norms[j] - 2 * product;
        enter(of_queries, k, i, distance, targets.numbers[j]);
        enter(of_targets, k, j, distance, queries.numbers[i]);
      }
    }
  }
}

}  // namespace consimd::detail::scalar
