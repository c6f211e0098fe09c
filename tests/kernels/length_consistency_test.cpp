#include <consimd/kernels/length_consistency.hpp>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

/// The test as length_consistency.hpp states it, operation by operation.
bool length_consistent(const detail::RawView& v, std::size_t j, std::size_t k, float bound) {
  float a = 0.0f;
  float b = 0.0f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float dp = v.source[axis][j] - v.source[axis][k];
    const float dq = v.target[axis][j] - v.target[axis][k];
    a = axis == 0 ? dp * dp : a + dp * dp;
    b = axis == 0 ? dq * dq : b + dq * dq;
  }
  const float squared = bound * bound;
  const float fourth = squared * squared;
  const float limit = 2.0f * squared * (a + b) - fourth;
  return (a - b) * (a - b) < (limit > fourth ? limit : fourth);
}

class LengthConsistency : public PerIsa {};
CONSIMD_FOR_EACH_ISA(LengthConsistency);

TEST_P(LengthConsistency, EqualsTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float bound) {
    std::vector<std::uint32_t> seeds(cloud.size() == 0 ? 0 : cloud.size() % 6);
    for (auto& seed : seeds) seed = cloud.any_index();
    expect_consensus(
        cloud, seeds.size(),
        [&](std::size_t s, std::size_t j) { return length_consistent(cloud.view(), j, seeds[s], bound); },
        [&](std::uint32_t* counts) { table().length_counts(cloud.view(), seeds.data(), seeds.size(), bound, counts); },
        [&](std::uint64_t* bits, std::uint32_t* counts) {
          table().length_bits(cloud.view(), seeds.data(), seeds.size(), bound, bits, counts);
        });
  });
}

TEST_P(LengthConsistency, CrossesCacheBlocks) {
  RawCloud cloud(2500, Kind::random, 3);
  const std::vector<std::uint32_t> seeds{0, 1023, 1024, 2499, 7, 7, 7};
  expect_consensus(
      cloud, seeds.size(),
      [&](std::size_t s, std::size_t j) { return length_consistent(cloud.view(), j, seeds[s], 0.1f); },
      [&](std::uint32_t* counts) { table().length_counts(cloud.view(), seeds.data(), seeds.size(), 0.1f, counts); },
      [&](std::uint64_t* bits, std::uint32_t* counts) {
        table().length_bits(cloud.view(), seeds.data(), seeds.size(), 0.1f, bits, counts);
      });
}

TEST_P(LengthConsistency, AgreesWithTheTextbookFormAwayFromTheThreshold) {
  RawCloud cloud(1000, Kind::random, 5);
  const auto view = cloud.view();
  const auto distance = [&](const float* const points[3], std::size_t j, std::size_t k) {
    double squared = 0.0;
    for (int axis = 0; axis < 3; ++axis) squared += std::pow(double{points[axis][j]} - double{points[axis][k]}, 2.0);
    return std::sqrt(squared);
  };
  std::size_t compared = 0;
  for (const float bound : {1e-4f, 1e-3f, 1e-2f, 0.1f, 1.0f, 4.0f}) {
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
      std::vector<std::uint64_t> bits(cloud.words());
      std::uint32_t count = 0;
      table().length_bits(view, &seed, 1, bound, bits.data(), &count);
      for (std::size_t j = 0; j < cloud.size(); ++j) {
        const double difference = std::abs(distance(view.source, j, seed) - distance(view.target, j, seed));
        if (std::abs(difference - double{bound}) < 1e-3 * double{bound} + 1e-6) continue;
        ASSERT_EQ((bits[j / 64] >> (j % 64) & 1) != 0, difference < double{bound})
            << "bound " << bound << ", " << seed << ", " << j;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 230'000u);
}

TEST(LengthConsistencyArguments, AreChecked) {
  const std::array<double, 9> points{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const auto span = PointSpan<double>::interleaved(points.data(), 3);
  const Correspondences c(span, span);
  std::vector<std::uint32_t> seeds{0, 2};
  std::vector<std::uint32_t> counts(2);
  std::vector<std::uint64_t> bits(2);
  length_consistency_bits(c, seeds, 0.1, bits, counts);
  EXPECT_EQ(counts, (std::vector<std::uint32_t>{3, 3}));
  EXPECT_EQ(bits, (std::vector<std::uint64_t>{7, 7}));

  for (const double bound : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW(length_consistency_counts(c, seeds, bound, counts), std::invalid_argument);
  }
  EXPECT_THROW(length_consistency_counts(c, seeds, 0.1, std::span(counts).first(1)), std::invalid_argument);
  EXPECT_THROW(length_consistency_bits(c, seeds, 0.1, std::span(bits).first(1), counts), std::invalid_argument);
  seeds[1] = 3;
  EXPECT_THROW(length_consistency_counts(c, seeds, 0.1, counts), std::out_of_range);
}

TEST(LengthConsistencyArguments, TakeBoundsOfAnySize) {
  const std::array<double, 6> source{0, 0, 0, 1, 0, 0};
  const std::array<double, 6> target{0, 0, 0, 2, 0, 0};
  const Correspondences c(PointSpan<double>::interleaved(source.data(), 2),
                          PointSpan<double>::interleaved(target.data(), 2));
  const std::vector<std::uint32_t> seeds{0};
  std::vector<std::uint32_t> counts(1);
  for (const double bound : {1e-300, 0.99, 1.01, 1e300}) {
    length_consistency_counts(c, seeds, bound, counts);
    EXPECT_EQ(counts[0], bound > 1.0 ? 2u : 1u) << bound;
  }
}

}  // namespace
}  // namespace consimd::test
