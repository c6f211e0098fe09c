#include <consimd/kernels/length_ratio.hpp>

#include <consimd/kernels/consistency_matrix.hpp>

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

class LengthRatio : public PerIsa {};
CONSIMD_FOR_EACH_ISA(LengthRatio);

double length(const float* const points[3], std::size_t i, std::size_t j) {
  return std::hypot(static_cast<double>(points[0][i]) - static_cast<double>(points[0][j]),
                    static_cast<double>(points[1][i]) - static_cast<double>(points[1][j]),
                    static_cast<double>(points[2][i]) - static_cast<double>(points[2][j]));
}

/// Equal bits, or both not a number.
void expect_same(const std::vector<float>& a, const std::vector<float>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (std::isnan(a[k]) && std::isnan(b[k])) continue;
    ASSERT_EQ(std::bit_cast<std::uint32_t>(a[k]), std::bit_cast<std::uint32_t>(b[k]))
        << k << ": " << a[k] << ", " << b[k];
  }
}

TEST_P(LengthRatio, EqualsTheReference) {
  const detail::KernelTable& reference = detail::table_of(Isa::scalar);
  for (const Kind kind : kKinds) {
    for (const std::size_t size : {1U, 2U, 17U, 63U, 64U, 65U, 130U, 260U, 1100U}) {
      SCOPED_TRACE(::testing::Message() << kind << " cloud of " << size);
      RawCloud cloud(size, kind, 21);
      const detail::RatioBounds bounds{bound_of(kind), 0.1f};
      const std::array<std::uint32_t, 3> seeds{cloud.any_index(), cloud.any_index(), cloud.any_index()};
      ExactArray<float> costs(3);
      ExactArray<float> expected(3);
      table().length_disagreement(cloud.view(), seeds.data(), 3, bounds, costs.data());
      reference.length_disagreement(cloud.view(), seeds.data(), 3, bounds, expected.data());
      expect_same(costs.values(), expected.values());

      ExactArray<float> lows(cloud.padded());
      ExactArray<float> highs(cloud.padded());
      ExactArray<float> expected_lows(cloud.padded());
      ExactArray<float> expected_highs(cloud.padded());
      table().scale_intervals(cloud.view(), seeds[0], bounds.bound, lows.data(), highs.data());
      reference.scale_intervals(cloud.view(), seeds[0], bounds.bound, expected_lows.data(), expected_highs.data());
      expect_same(lows.values(), expected_lows.values());
      expect_same(highs.values(), expected_highs.values());

      ExactArray<std::uint64_t> bits(size * cloud.words());
      ExactArray<std::uint64_t> expected_bits(size * cloud.words());
      ExactArray<std::uint32_t> degrees(size);
      ExactArray<std::uint32_t> expected_degrees(size);
      table().ratio_matrix(cloud.view(), bounds, bits.data(), degrees.data());
      reference.ratio_matrix(cloud.view(), bounds, expected_bits.data(), expected_degrees.data());
      ASSERT_EQ(bits.values(), expected_bits.values());
      ASSERT_EQ(degrees.values(), expected_degrees.values());
    }
  }
}

TEST_P(LengthRatio, DisagreementIsThatOfTheLogarithms) {
  const RawCloud cloud(500, Kind::random, 2);
  const detail::RawView view = cloud.view();
  for (const auto& [bound, logarithm] : {std::pair(16.0f, 0.1), std::pair(0.05f, 0.3), std::pair(0.1f, 0.1)}) {
    const std::uint32_t seed = 77;
    float cost = 0.0f;
    table().length_disagreement(view, &seed, 1, {bound, static_cast<float>(std::tanh(logarithm))}, &cost);
    double expected = 0.0;
    for (std::size_t j = 0; j < cloud.size(); ++j) {
      if (j == seed) continue;
      const double a = length(view.source, j, seed);
      const double b = length(view.target, j, seed);
      const double by_ratio = std::tanh(std::abs(std::log(b / a))) / std::tanh(logarithm);
      const double by_length = std::abs(b - a) / static_cast<double>(bound);
      expected += std::min(std::max(by_ratio, by_length), 1.0);
    }
    EXPECT_NEAR(static_cast<double>(cost), expected, 2e-4 * expected) << bound;
    EXPECT_LT(cost, 499.0f);
  }
}

TEST_P(LengthRatio, IntervalsAreTheConsistentScales) {
  const RawCloud cloud(300, Kind::random, 9);
  const detail::RawView view = cloud.view();
  constexpr float kBound = 0.3f;
  ExactArray<float> lows(cloud.padded());
  ExactArray<float> highs(cloud.padded());
  table().scale_intervals(view, 5, kBound, lows.data(), highs.data());
  for (std::size_t j = 0; j < cloud.size(); ++j) {
    if (j == 5) continue;
    const double a = length(view.source, j, 5);
    const double b = length(view.target, j, 5);
    EXPECT_NEAR(static_cast<double>(lows[j]), std::max(b - 0.3, 0.0) / a, 1e-4);
    EXPECT_NEAR(static_cast<double>(highs[j]), (b + 0.3) / a, 1e-4);
  }
  EXPECT_FALSE(std::isfinite(highs[5]));
  EXPECT_TRUE(std::isnan(highs[300]));
}

TEST_P(LengthRatio, MatrixBoundsTheLogarithm) {
  const RawCloud cloud(300, Kind::random, 4);
  const detail::RawView view = cloud.view();
  constexpr double kLogarithm = 0.2;
  constexpr double kBound = 0.2;
  ExactArray<std::uint64_t> bits(cloud.size() * cloud.words());
  ExactArray<std::uint32_t> degrees(cloud.size());
  table().ratio_matrix(view, {static_cast<float>(kBound), static_cast<float>(std::tanh(kLogarithm))}, bits.data(),
                       degrees.data());
  std::array<std::size_t, 2> seen{};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (std::size_t j = 0; j < cloud.size(); ++j) {
      const bool bit = (bits[i * cloud.words() + j / 64] >> (j % 64) & 1) != 0;
      const double a = length(view.source, i, j);
      const double b = length(view.target, i, j);
      const double q = i == j ? 1.0 : std::abs(std::log(b / a));
      if (std::abs(q - kLogarithm) < 1e-4 || std::abs(std::abs(b - a) - kBound) < 1e-4) continue;
      ASSERT_EQ(bit, q < kLogarithm && std::abs(b - a) < kBound) << i << ", " << j;
      ++seen[bit ? 1 : 0];
    }
  }
  EXPECT_GT(seen[0], 1000u);
  EXPECT_GT(seen[1], 1000u);
}

TEST(LengthRatioArguments, AreChecked) {
  const std::array<double, 9> points{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const auto span = PointSpan<double>::interleaved(points.data(), 3);
  const Correspondences c(span, span);
  const std::array<std::uint32_t, 1> seed{0};
  const std::array<std::uint32_t, 1> beyond{3};
  std::array<float, 1> cost{};
  std::vector<float> ends(64);
  for (const double ratio : {0.0, 1.0, -0.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(length_disagreement(c, seed, 1.0, ratio, cost), std::invalid_argument);
    ConsistencyMatrix matrix;
    EXPECT_THROW(matrix.compute_ratio(c, 1.0, ratio), std::invalid_argument);
  }
  EXPECT_THROW(length_disagreement(c, seed, 0.0, 0.1, cost), std::invalid_argument);
  EXPECT_THROW(length_disagreement(c, seed, 1.0, 0.1, {}), std::invalid_argument);
  EXPECT_THROW(length_disagreement(c, beyond, 1.0, 0.1, cost), std::out_of_range);
  EXPECT_THROW(scale_intervals(c, 3, 1.0, ends, ends), std::out_of_range);
  EXPECT_THROW(scale_intervals(c, 0, -1.0, ends, ends), std::invalid_argument);
  EXPECT_THROW(scale_intervals(c, 0, 1.0, std::span(ends).first(3), ends), std::invalid_argument);
  length_disagreement(c, seed, 1.0, 0.1, cost);
  EXPECT_EQ(cost[0], 0.0f);
}

TEST(ScaledSource, MultipliesAboutTheFramesOrigin) {
  const std::array<double, 9> source{1000.0, 0, 0, 1004.0, 2.0, 0, 1002.0, 1.0, 8.0};
  const std::array<double, 9> target{0, 0, 0, 1, 2, 3, 5, 0, 7};
  const Correspondences c(PointSpan<double>::interleaved(source.data(), 3),
                          PointSpan<double>::interleaved(target.data(), 3));
  for (const double factor : {1.0, 0.01, 0.3, 7.0, 1e6}) {
    std::array<double, 9> moved = source;
    for (double& x : moved) x *= factor;
    const Correspondences expected(PointSpan<double>::interleaved(moved.data(), 3),
                                   PointSpan<double>::interleaved(target.data(), 3));
    const Correspondences scaled = c.with_scaled_source(factor);
    EXPECT_EQ(scaled.scale(), expected.scale()) << factor;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(scaled.source_centroid()[axis], expected.source_centroid()[axis], 1e-9 * factor);
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(scaled.view().source(axis)[k], expected.view().source(axis)[k], 2e-7) << factor;
        EXPECT_NEAR(scaled.view().target(axis)[k], expected.view().target(axis)[k], 2e-7) << factor;
      }
      EXPECT_TRUE(std::isnan(scaled.view().source(axis)[3]));
    }
  }
  for (const double factor : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(static_cast<void>(c.with_scaled_source(factor)), std::invalid_argument);
  }
}

}  // namespace
}  // namespace consimd::test
