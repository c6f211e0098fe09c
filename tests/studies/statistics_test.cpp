#include <consimd/studies/statistics.hpp>

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace consimd::studies {
namespace {

struct Known {
  std::size_t successes, trials;
  double low, high;
};

// R. G. Newcombe, "Two-sided confidence intervals for the single proportion", Statistics in Medicine 17, 1998, table I,
// method 3.
TEST(WilsonInterval, AgreesWithPublishedValues) {
  for (const Known& known : {Known{81, 263, 0.2553, 0.3662}, Known{15, 148, 0.0624, 0.1605}, Known{0, 20, 0.0, 0.1611},
                             Known{1, 29, 0.0061, 0.1718}}) {
    const Interval interval = wilson_interval(known.successes, known.trials);
    EXPECT_NEAR(interval.low, known.low, 5e-5) << known.successes << "/" << known.trials;
    EXPECT_NEAR(interval.high, known.high, 5e-5) << known.successes << "/" << known.trials;
  }
}

TEST(WilsonInterval, StaysInTheUnitIntervalAroundTheProportion) {
  for (std::size_t trials = 1; trials <= 120; ++trials) {
    for (std::size_t successes = 0; successes <= trials; ++successes) {
      const Interval interval = wilson_interval(successes, trials);
      const double proportion = static_cast<double>(successes) / static_cast<double>(trials);
      EXPECT_GE(interval.low, 0.0);
      EXPECT_LE(interval.low, proportion);
      EXPECT_GE(interval.high, proportion);
      EXPECT_LE(interval.high, 1.0);
      EXPECT_LT(interval.low, interval.high);
    }
  }
}

TEST(WilsonInterval, KnowsNothingWithoutTrials) {
  EXPECT_EQ(wilson_interval(0, 0).low, 0.0);
  EXPECT_EQ(wilson_interval(0, 0).high, 1.0);
  EXPECT_THROW((void)wilson_interval(2, 1), std::invalid_argument);
}

TEST(Median, IsTheMiddle) {
  EXPECT_EQ(median({3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median({4.0, 1.0, 2.0, 3.0}), 2.5);
  EXPECT_EQ(median({7.0}), 7.0);
  EXPECT_TRUE(std::isnan(median({})));
}

}  // namespace
}  // namespace consimd::studies
