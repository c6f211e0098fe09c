#include <consimd/kernels/angle_consistency.hpp>

#include <numbers>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

float squared_distance(const float* const points[3], std::size_t j, std::size_t k) {
  const float x = points[0][j] - points[0][k];
  const float y = points[1][j] - points[1][k];
  const float z = points[2][j] - points[2][k];
  return x * x + y * y + z * z;
}

/// The test as angle_consistency.hpp states it, operation by operation.
bool angle_consistent(const detail::RawView& v, IndexPair pair, std::size_t m, float bound) {
  const float B = bound * bound;
  const float a1 = squared_distance(v.source, pair.first, m);
  const float a2 = squared_distance(v.source, pair.second, m);
  const float b1 = squared_distance(v.target, pair.first, m);
  const float b2 = squared_distance(v.target, pair.second, m);
  const float X = a1 * a2;
  const float Y = b1 * b2;
  const float U = (a1 + a2) - squared_distance(v.source, pair.first, pair.second);
  const float V = (b1 + b2) - squared_distance(v.target, pair.first, pair.second);
  const float e1 = a1 - B;
  const float e2 = a2 - B;
  const float c = std::sqrt(e1 * e2) - B;
  const float F = 0x1p40f * (V * X - (U * c) * std::sqrt(Y));
  if (F * F < ((4.0f * X - U * U) * ((a1 + a2) + (c + c))) * (((B * 0x1p40f) * 0x1p40f) * Y)) return true;
  if (std::fabs(F) * (c + c) < F * U) return true;
  return (e1 < e2 ? e1 : e2) <= 0.0f;
}

class AngleConsistency : public PerIsa {};
CONSIMD_FOR_EACH_ISA(AngleConsistency);

TEST_P(AngleConsistency, EqualsTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float bound) {
    std::vector<IndexPair> pairs(cloud.size() == 0 ? 0 : cloud.size() % 5);
    for (auto& pair : pairs) pair = {cloud.any_index(), cloud.any_index()};
    expect_consensus(
        cloud, pairs.size(),
        [&](std::size_t s, std::size_t m) { return angle_consistent(cloud.view(), pairs[s], m, bound); },
        [&](std::uint32_t* counts) { table().angle_counts(cloud.view(), pairs.data(), pairs.size(), bound, counts); },
        [&](std::uint64_t* bits, std::uint32_t* counts) {
          table().angle_bits(cloud.view(), pairs.data(), pairs.size(), bound, bits, counts);
        });
  });
}

struct Textbook {
  double excess;     ///< angle difference less the sum of the arcsines
  double tolerance;  ///< the sum of the arcsines
  double sine;       ///< smaller sine of the two angles
  bool within_bound;
};

Textbook textbook(const detail::RawView& v, IndexPair pair, std::size_t m, double bound) {
  const auto vector = [&](const float* const points[3], std::size_t i) {
    return std::array{double{points[0][i]} - double{points[0][m]}, double{points[1][i]} - double{points[1][m]},
                      double{points[2][i]} - double{points[2][m]}};
  };
  const auto dot = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const auto angle = [&](const auto& a, const auto& b) {
    return std::acos(std::clamp(dot(a, b) / std::sqrt(dot(a, a) * dot(b, b)), -1.0, 1.0));
  };
  const auto x1 = vector(v.source, pair.first);
  const auto x2 = vector(v.source, pair.second);
  const double source_angle = angle(x1, x2);
  const double target_angle = angle(vector(v.target, pair.first), vector(v.target, pair.second));
  const double l1 = std::sqrt(dot(x1, x1));
  const double l2 = std::sqrt(dot(x2, x2));
  Textbook t{};
  t.within_bound = l1 <= bound || l2 <= bound;
  t.tolerance = std::asin(std::min(bound / l1, 1.0)) + std::asin(std::min(bound / l2, 1.0));
  t.excess = std::abs(source_angle - target_angle) - t.tolerance;
  t.sine = std::min(std::sin(source_angle), std::sin(target_angle));
  return t;
}

TEST_P(AngleConsistency, AgreesWithTheTextbookFormAwayFromTheThreshold) {
  std::size_t compared = 0;
  std::size_t consistent = 0;
  for (const float bound : {1e-4f, 1e-3f, 1e-2f, 0.1f, 0.3f, 1.0f}) {
    // targets move by up to three bounds, so the differences of the angles are of the size of the tolerance
    std::mt19937 random(7);
    RawCloud cloud(600, Kind::random, 11);
    std::array<ExactArray<float>, 3> moved{ExactArray<float>(cloud.padded(), std::nanf("")),
                                           ExactArray<float>(cloud.padded(), std::nanf("")),
                                           ExactArray<float>(cloud.padded(), std::nanf(""))};
    detail::RawView view = cloud.view();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t j = 0; j < cloud.size(); ++j) {
        moved[axis][j] = view.source[axis][j] + 3.0f * bound * uniform(random);
      }
      view.target[axis] = moved[axis].data();
    }
    for (int s = 0; s < 40; ++s) {
      const IndexPair pair{cloud.any_index(), cloud.any_index()};
      if (pair.first == pair.second) continue;
      std::vector<std::uint64_t> bits(cloud.words());
      std::uint32_t count = 0;
      table().angle_bits(view, &pair, 1, bound, bits.data(), &count);
      for (std::size_t m = 0; m < cloud.size(); ++m) {
        if (m == pair.first || m == pair.second) continue;
        const Textbook t = textbook(view, pair, m, double{bound});
        if (t.sine < 0.02 || std::abs(t.excess) < 0.02 * t.tolerance) continue;
        const bool expected = t.within_bound || t.excess < 0.0;
        ASSERT_EQ((bits[m / 64] >> (m % 64) & 1) != 0, expected)
            << "bound " << bound << ", " << pair.first << ", " << pair.second << ", " << m << ", excess " << t.excess;
        ++compared;
        consistent += expected ? 1 : 0;
      }
    }
  }
  EXPECT_GT(compared, 120'000u);
  EXPECT_GT(consistent, compared / 10);
  EXPECT_LT(consistent, compared - compared / 10);
}

TEST_P(AngleConsistency, KeepsShortBaselines) {
  // three points 1e-4 of the frame apart and a tenth of that as bound: no product may underflow
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::vector<ExactArray<float>> rows;
  rows.reserve(6);
  for (int row = 0; row < 6; ++row) rows.emplace_back(64, kNan);
  const float corners[3][3] = {{0, 0, 0}, {1e-4f, 0, 0}, {0.3e-4f, 0.8e-4f, 0}};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t axis = 0; axis < 3; ++axis) rows[axis][j] = rows[3 + axis][j] = corners[j][axis];
  }
  const detail::RawView view{
      {rows[0].data(), rows[1].data(), rows[2].data()}, {rows[3].data(), rows[4].data(), rows[5].data()}, 3, 64};
  const IndexPair pair{0, 1};
  std::uint32_t count = 0;
  table().angle_counts(view, &pair, 1, 1e-5f, &count);
  EXPECT_EQ(count, 3u);
}

TEST(AngleConsistencyArguments, AreChecked) {
  const std::array<double, 9> points{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const auto span = PointSpan<double>::interleaved(points.data(), 3);
  const Correspondences c(span, span);
  std::vector<IndexPair> pairs{{0, 1}};
  std::vector<std::uint32_t> counts(1);
  std::vector<std::uint64_t> bits(1);
  angle_consistency_bits(c, pairs, 0.1, bits, counts);
  EXPECT_EQ(counts[0], 3u);
  EXPECT_EQ(bits[0], 7u);
  EXPECT_THROW(angle_consistency_counts(c, pairs, 0.0, counts), std::invalid_argument);
  EXPECT_THROW(angle_consistency_bits(c, pairs, 0.1, {}, counts), std::invalid_argument);
  pairs[0].second = 3;
  EXPECT_THROW(angle_consistency_counts(c, pairs, 0.1, counts), std::out_of_range);
}

}  // namespace
}  // namespace consimd::test
