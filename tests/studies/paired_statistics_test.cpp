#include <consimd/studies/paired_statistics.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace consimd::studies {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Uniform in [0, 1): a linear congruential generator of 64 bits will do to make data up.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : state_(seed) {
    for (int i = 0; i < 4; ++i) static_cast<void>((*this)());
  }
  double operator()() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

/// The exact values, from sums of binomial coefficients as fractions.
TEST(McNemar, HasTheExactValues) {
  EXPECT_NEAR(mcnemar_p_value(12, 1), 0.00341796875, 1e-15);
  EXPECT_NEAR(mcnemar_p_value(1, 12), 0.00341796875, 1e-15);
  EXPECT_NEAR(mcnemar_p_value(5, 0), 0.0625, 1e-15);
  EXPECT_NEAR(mcnemar_p_value(10, 20), 0.09873714670538902, 1e-14);
  EXPECT_NEAR(mcnemar_p_value(1000, 1100), 0.030720707864242296, 1e-11);
  EXPECT_NEAR(mcnemar_p_value(0, 1), 1.0, 1e-15);
  EXPECT_NEAR(mcnemar_p_value(3, 4), 1.0, 1e-15);
}

TEST(McNemar, EqualNumbersAreNoEvidenceAndThousandsAreAll) {
  EXPECT_EQ(mcnemar_p_value(0, 0), 1.0);
  EXPECT_EQ(mcnemar_p_value(7, 7), 1.0);
  EXPECT_GE(mcnemar_p_value(0, 5000), 0.0);
  EXPECT_LT(mcnemar_p_value(0, 5000), 1e-300);
  EXPECT_LT(mcnemar_p_value(0, 1'000'000'000), 1e-300);
}

/// The rate of false alarms at 0.05 is at most that; being discrete, the test has less with few trials.
TEST(McNemar, HasItsRateOfFalseAlarms) {
  Uniform random(7);
  constexpr int kStudies = 4000;
  int alarms = 0;
  for (int study = 0; study < kStudies; ++study) {
    std::size_t only_a = 0, only_b = 0;
    for (int trial = 0; trial < 200; ++trial) {
      const bool a = random() < 0.6, b = random() < 0.6;
      only_a += a && !b;
      only_b += b && !a;
    }
    alarms += mcnemar_p_value(only_a, only_b) < 0.05;
  }
  const double rate = alarms / static_cast<double>(kStudies);
  EXPECT_LT(rate, 0.05 + 3.0 * std::sqrt(0.05 * 0.95 / kStudies));
  EXPECT_GT(rate, 0.02);
}

TEST(Holm, HasThePapersSteps) {
  // Sorted 0.0625, 0.125, 0.25 times 3, 2, 1, and never less than the one before.
  EXPECT_EQ(holm_adjusted({0.25, 0.0625, 0.125}), (std::vector<double>{0.25, 0.1875, 0.25}));
  EXPECT_EQ(holm_adjusted({0.15625, 0.125, 0.875}), (std::vector<double>{0.375, 0.375, 0.875}));
  EXPECT_EQ(holm_adjusted({0.6, 0.7}), (std::vector<double>{1.0, 1.0}));
  EXPECT_TRUE(holm_adjusted({}).empty());
  for (const double bad : {-0.1, 1.1, kNaN}) EXPECT_THROW((void)holm_adjusted({bad}), std::invalid_argument);
}

TEST(Quantile, CountsFailures) {
  const std::vector<double> values{3.0, 1.0, kInfinity, 2.0};
  EXPECT_EQ(quantile(values, 0.25), 1.0);
  EXPECT_EQ(quantile(values, 0.26), 2.0);
  EXPECT_EQ(quantile(values, 0.75), 3.0);
  EXPECT_EQ(quantile(values, 0.9), kInfinity);
  EXPECT_EQ(quantile(values, 1e-9), 1.0);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
  for (const double q : {0.0, 1.1, kNaN}) EXPECT_THROW((void)quantile(values, q), std::invalid_argument);
  EXPECT_THROW((void)quantile({kNaN}, 0.5), std::invalid_argument);
}

TEST(Bootstrap, TakesTheSameTrialsForTheSameKey) {
  const std::vector<double> values{1.0, 5.0, 2.0, 8.0, 3.0};
  const BootstrapMeans one(5, 1, 2);
  EXPECT_EQ(one.of(values), BootstrapMeans(5, 1, 2).of(values));
  EXPECT_NE(one.of(values), BootstrapMeans(5, 1, 3).of(values));
  EXPECT_NE(one.of(values), BootstrapMeans(5, 2, 2).of(values));
  // Paired: a difference that is the same in every trial is so in every sample.
  std::vector<double> more = values;
  for (double& value : more) value += 1.0;
  const std::vector<double> means = one.of(values), of_more = one.of(more);
  for (std::size_t r = 0; r < means.size(); ++r) EXPECT_NEAR(of_more[r] - means[r], 1.0, 1e-12);
}

TEST(Bootstrap, RefusesAnotherNumberOfValues) {
  EXPECT_THROW((void)BootstrapMeans(3, 1, 1).of(std::vector<double>{1.0}), std::invalid_argument);
  EXPECT_TRUE(BootstrapMeans(0, 1, 1).of({}).empty());
  EXPECT_TRUE(std::isnan(bootstrap_interval({}).low));
}

TEST(Bootstrap, HasTheSpreadOfAMean) {
  Uniform random(3);
  std::vector<double> values(400);
  for (double& value : values) value = random();
  const std::vector<double> means = BootstrapMeans(values.size(), 1, 1).of(values);
  double mean = 0.0, square = 0.0;
  for (const double m : means) mean += m / static_cast<double>(means.size());
  for (const double m : means) square += (m - mean) * (m - mean) / static_cast<double>(means.size());
  EXPECT_NEAR(std::sqrt(square), std::sqrt(1.0 / 12.0 / 400.0), 0.002);
}

/// Of the intervals of a difference that is none, about 5 % leave zero out; somewhat more with few trials.
TEST(Bootstrap, HasItsRateOfFalseAlarms) {
  Uniform random(11);
  constexpr std::uint64_t kStudies = 600;
  double alarms = 0.0;
  for (std::uint64_t study = 0; study < kStudies; ++study) {
    std::vector<double> differences(60);
    for (double& d : differences) {
      d = random() * random();
      d -= random() * random();
    }
    const Interval interval = bootstrap_interval(BootstrapMeans(differences.size(), 1, study).of(differences));
    alarms += interval.low > 0.0 || interval.high < 0.0;
  }
  EXPECT_GT(alarms / kStudies, 0.025);
  EXPECT_LT(alarms / kStudies, 0.085);
}

}  // namespace
}  // namespace consimd::studies
