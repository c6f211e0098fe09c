#include "random_stream.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace consimd::synth {
namespace {

constexpr ProblemKey kKey{.seed = 7, .cell = 11, .trial = 13};

/// Largest distance between the samples' empirical distribution and the uniform one on [0, 1], in units of its scale
/// 1 / sqrt(n): above 1.95 with chance 0.001 (Kolmogorov).
double kolmogorov_statistic(std::vector<double> samples) {
  std::ranges::sort(samples);
  const auto n = static_cast<double>(samples.size());
  double distance = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto rank = static_cast<double>(i);
    distance = std::max({distance, samples[i] - rank / n, (rank + 1.0) / n - samples[i]});
  }
  return distance * std::sqrt(n);
}

constexpr double kKolmogorovLimit = 1.95;

TEST(RandomStream, IsPhilox4x64WithTheCounterOfTheContract) {
  RandomStream stream(kKey, Purpose::noise);
  for (std::uint64_t block = 0; block < 3; ++block) {
    const auto expected = r123::Philox4x64{}({{block, kKey.trial, static_cast<std::uint64_t>(Purpose::noise), 0}},
                                             {{kKey.seed, kKey.cell}});
    for (const std::uint64_t word : expected) EXPECT_EQ(stream.bits(), word);
  }
}

TEST(RandomStream, EveryPartOfTheKeySelectsAnotherSequence) {
  std::set<std::uint64_t> first_words;
  for (const ProblemKey& key :
       {kKey, ProblemKey{8, 11, 13}, ProblemKey{7, 12, 13}, ProblemKey{7, 11, 14}, ProblemKey{11, 7, 13}}) {
    for (const Purpose purpose : {Purpose::motion, Purpose::points, Purpose::noise}) {
      first_words.insert(RandomStream(key, purpose).bits());
    }
  }
  EXPECT_EQ(first_words.size(), 15u);
}

TEST(RandomStream, UniformFillsTheUnitInterval) {
  RandomStream stream(kKey, Purpose::points);
  std::vector<double> samples(20000);
  std::ranges::generate(samples, [&] { return stream.uniform(); });
  EXPECT_GE(*std::ranges::min_element(samples), 0.0);
  EXPECT_LT(*std::ranges::max_element(samples), 1.0);
  EXPECT_LT(kolmogorov_statistic(samples), kKolmogorovLimit);
}

TEST(RandomStream, GaussianHasTheNormalDistribution) {
  RandomStream stream(kKey, Purpose::noise);
  std::vector<double> probabilities(20000);
  double neighbours = 0.0, previous = 0.0;
  for (double& probability : probabilities) {
    const double x = stream.gaussian();
    probability = 0.5 * std::erfc(-x / std::numbers::sqrt2);
    neighbours += x * previous;
    previous = x;
  }
  EXPECT_LT(kolmogorov_statistic(probabilities), kKolmogorovLimit);
  EXPECT_LT(std::abs(neighbours) / std::sqrt(20000.0), 4.0);  // both of a Box-Muller pair are used: uncorrelated
}

TEST(RandomStream, BelowReachesEveryValueEquallyOften) {
  RandomStream stream(kKey, Purpose::order);
  std::array<int, 7> counts{};
  for (int i = 0; i < 70000; ++i) ++counts.at(stream.below(7));
  double chi_square = 0.0;
  for (const int count : counts) chi_square += (count - 10000.0) * (count - 10000.0) / 10000.0;
  EXPECT_LT(chi_square, 22.5);  // 6 degrees of freedom, chance 0.001
  EXPECT_EQ(stream.below(1), 0u);
  for (int i = 0; i < 100; ++i) EXPECT_LT(stream.below(0xffffffffu), 0xffffffffu);
}

TEST(RandomStream, RotationsAreProperAndUniform) {
  RandomStream stream(kKey, Purpose::motion);
  std::vector<double> angles, heights;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Matrix3d rotation = stream.rotation();
    EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(rotation.determinant(), 0.0);
    const double angle = Eigen::AngleAxisd(rotation).angle();
    angles.push_back((angle - std::sin(angle)) / std::numbers::pi);  // Haar measure
    heights.push_back(0.5 + 0.5 * rotation(2, 0));                   // Archimedes: uniform on the sphere
  }
  EXPECT_LT(kolmogorov_statistic(angles), kKolmogorovLimit);
  EXPECT_LT(kolmogorov_statistic(heights), kKolmogorovLimit);
}

TEST(RandomStream, ShuffleReachesEveryOrderEquallyOften) {
  RandomStream stream(kKey, Purpose::order);
  std::array<int, 24> counts{};
  std::array<int, 4> values{};
  for (int i = 0; i < 24000; ++i) {
    std::iota(values.begin(), values.end(), 0);
    stream.shuffle(std::span<int>(values));
    int index = 0;  // of the order in the list of all, by Lehmer's code
    for (std::size_t a = 0; a < 4; ++a) {
      const auto smaller = std::count_if(values.begin() + static_cast<std::ptrdiff_t>(a), values.end(),
                                         [&](int value) { return value < values[a]; });
      index = index * static_cast<int>(4 - a) + static_cast<int>(smaller);
    }
    ++counts.at(static_cast<std::size_t>(index));
  }
  double chi_square = 0.0;
  for (const int count : counts) chi_square += (count - 1000.0) * (count - 1000.0) / 1000.0;
  EXPECT_LT(chi_square, 49.7);  // 23 degrees of freedom, chance 0.001
}

}  // namespace
}  // namespace consimd::synth
