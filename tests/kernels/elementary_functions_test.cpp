#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include <consimd/kernels/elementary_functions.hpp>

namespace consimd::elementary {
namespace {

using Exact = long double;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSmallest = std::numeric_limits<double>::denorm_min();
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr int kDraws = 100000;

/// Of `value` from what the wider type gives, in units in the last place of that.
double ulp_error(double value, Exact exact) {
  const double nearest = static_cast<double>(exact);
  if (value == nearest) return 0.0;
  const double magnitude = std::max(std::abs(nearest), std::numeric_limits<double>::min());
  const double unit = std::ldexp(1.0, std::ilogb(magnitude) - 52);
  return static_cast<double>(std::abs(static_cast<Exact>(value) - exact) / static_cast<Exact>(unit));
}

/// Holds functions of one argument against the C library's of a wider type.
class Accuracy : public testing::Test {
 protected:
  void SetUp() override {
    if (std::numeric_limits<Exact>::digits < 64) GTEST_SKIP() << "long double is no wider than double here";
  }

  void TearDown() override {
    if (IsSkipped()) return;
    EXPECT_GT(worst_of_all_, 0.25) << "no rounding errors at all: the two are one";
  }

  /// `draw` gives the arguments, besides `edges`.
  template <typename Function, typename Reference, typename Draw>
  void expect_within(double bound, Function function, Reference reference, Draw draw) {
    double worst = 0.0;
    double worst_at = 0.0;
    for (int k = 0; k < kDraws; ++k) {
      const double x = draw();
      const double error = ulp_error(function(x), reference(Exact{x}));
      if (!(error <= worst)) {
        worst = error;
        worst_at = x;
      }
    }
    EXPECT_LE(worst, bound) << "at " << std::hexfloat << worst_at;
    worst_of_all_ = std::max(worst_of_all_, worst);
    RecordProperty("worst_ulp", std::to_string(worst));
  }

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  /// Any bits that make a positive, finite number: every exponent, subnormal ones as well.
  double any_positive() {
    return std::bit_cast<double>(
        std::uniform_int_distribution<std::uint64_t>(1, std::bit_cast<std::uint64_t>(kLargest))(engine_));
  }
  double any() { return std::copysign(any_positive(), uniform(-1.0, 1.0)); }

 private:
  std::mt19937_64 engine_{20240601};
  double worst_of_all_ = 0.0;
};

double sine(double x) { return sine_cosine(x).sine; }
double cosine(double x) { return sine_cosine(x).cosine; }
Exact exact_sine(Exact x) { return std::sin(x); }
Exact exact_cosine(Exact x) { return std::cos(x); }

TEST_F(Accuracy, Log) {
  const auto exact = [](Exact x) { return std::log(x); };
  expect_within(1.0, log, exact, [&] { return any_positive(); });
  expect_within(1.0, log, exact, [&] { return uniform(0.0, 1.0); });
  expect_within(1.0, log, exact, [&] { return uniform(0.5, 2.0); });
  expect_within(1.0, log, exact, [&] { return 1.0 + uniform(-1e-6, 1e-6); });
}

TEST_F(Accuracy, Log10) {
  const auto exact = [](Exact x) { return std::log10(x); };
  expect_within(1.0, log10, exact, [&] { return any_positive(); });
  expect_within(1.0, log10, exact, [&] { return uniform(0.5, 2.0); });
  expect_within(1.0, log10, exact, [&] { return uniform(0.0, 1e4); });
}

TEST_F(Accuracy, Log1p) {
  const auto exact = [](Exact x) { return std::log1p(x); };
  expect_within(2.0, log1p, exact, [&] { return any_positive(); });
  expect_within(2.0, log1p, exact, [&] { return uniform(-1.0, 1.0); });
  expect_within(2.0, log1p, exact, [&] { return uniform(-1e-3, 1e-3); });
  expect_within(2.0, log1p, exact, [&] { return uniform(-1e-15, 1e-15); });
}

TEST_F(Accuracy, Exp) {
  const auto exact = [](Exact x) { return std::exp(x); };
  expect_within(1.0, exp, exact, [&] { return uniform(-708.0, 709.7); });
  expect_within(2.0, exp, exact, [&] { return uniform(-745.0, -708.0); });  // subnormal
  expect_within(1.0, exp, exact, [&] { return uniform(-1.0, 1.0); });
}

TEST_F(Accuracy, Expm1) {
  const auto exact = [](Exact x) { return std::expm1(x); };
  expect_within(2.0, expm1, exact, [&] { return uniform(-60.0, 709.0); });
  expect_within(2.0, expm1, exact, [&] { return uniform(-2.0, 2.0); });
  expect_within(2.0, expm1, exact, [&] { return uniform(-1e-3, 1e-3); });
}

TEST_F(Accuracy, Tanh) {
  const auto exact = [](Exact x) { return std::tanh(x); };
  expect_within(3.0, tanh, exact, [&] { return uniform(-25.0, 25.0); });
  expect_within(3.0, tanh, exact, [&] { return uniform(-0.5, 0.5); });
}

TEST_F(Accuracy, Cbrt) {
  const auto exact = [](Exact x) { return std::cbrt(x); };
  expect_within(1.0, cbrt, exact, [&] { return any(); });
  expect_within(1.0, cbrt, exact, [&] { return uniform(0.5, 10.0); });
}

TEST_F(Accuracy, SineAndCosine) {
  for (const double reach : {1.0, 6.3, 1e3, 0x1p20}) {
    expect_within(1.0, sine, exact_sine, [&] { return uniform(-reach, reach); });
    expect_within(1.0, cosine, exact_cosine, [&] { return uniform(-reach, reach); });
  }
  // Where they vanish.
  for (const auto near : {1e-3, 1e-9, 1e-15}) {
    const auto draw = [&] { return std::floor(uniform(1.0, 600000.0)) * 1.5707963267948966 + uniform(-near, near); };
    expect_within(1.0, sine, exact_sine, draw);
    expect_within(1.0, cosine, exact_cosine, draw);
  }
}

TEST_F(Accuracy, Atan2) {
  for (const double x : {1.0, -1.0, 3e-310, -0x1.8p-300, 1e300}) {
    const auto of = [x](double y) { return atan2(y, x); };
    const auto exact = [x](Exact y) { return std::atan2(y, Exact{x}); };
    expect_within(2.0, of, exact, [&] { return x * uniform(-1.1, 1.1); });
    expect_within(2.0, of, exact, [&] { return x * uniform(-20.0, 20.0); });
  }
  for (int k = 0; k < kDraws; ++k) {
    const double y = any();
    const double x = any();
    ASSERT_LE(ulp_error(atan2(y, x), std::atan2(Exact{y}, Exact{x})), 2.0) << std::hexfloat << y << ' ' << x;
  }
}

TEST_F(Accuracy, InverseSineAndCosine) {
  const auto exact_asin = [](Exact x) { return std::asin(x); };
  const auto exact_acos = [](Exact x) { return std::acos(x); };
  expect_within(3.0, asin, exact_asin, [&] { return uniform(-1.0, 1.0); });
  expect_within(3.0, acos, exact_acos, [&] { return uniform(-1.0, 1.0); });
  expect_within(3.0, acos, exact_acos, [&] { return 1.0 - uniform(0.0, 1e-9); });
  expect_within(3.0, asin, exact_asin, [&] { return uniform(0.0, 1e-3); });
}

void expect_same(double value, double expected, const char* what, double x) {
  if (std::isnan(expected)) {
    EXPECT_TRUE(std::isnan(value)) << what << " of " << x << " is " << value;
  } else {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(expected))
        << what << " of " << x << " is " << value << ", expected " << expected;
  }
}

TEST(Elementary, ExactResultsAndEdges) {
  // Arguments whose results are exact, or special, in every library: C's annex F.
  for (const double x :
       {0.0, -0.0, kInfinity, -kInfinity, kNaN, kSmallest, -kSmallest, 0x1p-1022, -0x1p-1022, 1e-300}) {
    expect_same(log1p(x), std::log1p(x), "log1p", x);
    expect_same(exp(x), std::exp(x), "exp", x);
    expect_same(expm1(x), std::expm1(x), "expm1", x);
    expect_same(tanh(x), std::tanh(x), "tanh", x);
    expect_same(sine(x), std::sin(x), "sine", x);
    expect_same(cosine(x), std::cos(x), "cosine", x);
    expect_same(asin(x), std::asin(x), "asin", x);
    expect_same(acos(x), std::acos(x), "acos", x);
  }
  for (const double x : {0.0, -0.0, kInfinity, -kInfinity, kNaN, -1.0, -kSmallest, 1.0}) {
    expect_same(log(x), std::log(x), "log", x);
    expect_same(log10(x), std::log10(x), "log10", x);
  }
  for (const double x : {0.0, -0.0, kInfinity, -kInfinity, kNaN}) expect_same(cbrt(x), std::cbrt(x), "cbrt", x);
  double power = 1.0;
  for (double exponent = 0.0; exponent <= 22.0; ++exponent) {
    expect_same(log10(power), exponent, "log10", power);
    expect_same(log10(1.0 / power), 0.0 - exponent, "log10", 1.0 / power);
    power *= 10.0;
  }
  for (const double root : {1.0, -2.0, 3.0, -1000.0, 0x1p-300, 0x1p341, -0x1p-350}) {
    expect_same(cbrt(root * root * root), root, "cbrt", root * root * root);
  }
  for (const double x : {-1.0, -1.5, -kLargest}) expect_same(log1p(x), std::log1p(x), "log1p", x);
  for (const double x : {1000.0, -1000.0, kLargest, -kLargest, 710.0, -746.0}) {
    expect_same(exp(x), std::exp(x), "exp", x);
    expect_same(expm1(x), std::expm1(x), "expm1", x);
    expect_same(tanh(x), std::tanh(x), "tanh", x);
  }
  for (const double x : {1.0, -1.0, 1.0000001, -2.0, kLargest}) {
    expect_same(asin(x), std::asin(x), "asin", x);
    expect_same(acos(x), std::acos(x), "acos", x);
  }
  for (const double x : {0x1.0000000000001p20, -1e300}) {
    EXPECT_TRUE(std::isnan(sine(x))) << x;
    EXPECT_TRUE(std::isnan(cosine(x))) << x;
  }
}

TEST(Elementary, AnglesOfAxesZerosAndInfinities) {
  const std::array edges{0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity, kNaN, kSmallest, -kSmallest, kLargest, -kLargest};
  for (const double y : edges) {
    for (const double x : edges) expect_same(atan2(y, x), std::atan2(y, x), "atan2", y);
  }
}

TEST(Elementary, MonotoneAroundPowersOfTwo) {
  // Where the argument's reduction changes, a result must not fall behind the one before.
  for (int exponent = -20; exponent <= 20; ++exponent) {
    for (const double at : {std::ldexp(1.0, exponent), std::ldexp(1.4142135623730951, exponent)}) {
      double x = at;
      for (int k = 0; k < 8; ++k) x = std::nextafter(x, 0.0);
      double former = log(x);
      for (int k = 0; k < 16; ++k) {
        x = std::nextafter(x, kInfinity);
        EXPECT_GE(log(x), former) << std::hexfloat << x;
        former = log(x);
      }
    }
  }
}

TEST(Elementary, SameBitsAsEverywhere) {
  // FNV-1a over the bits of results; the number is the one that every processor and compiler gives.
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](double value) { hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3; };
  double x = 0x1.123456789abcdp-6;
  for (int k = 0; k < 20000; ++k) {
    x *= 1.0004321;  // up to 95
    const double unit = x / (1.0 + x);
    for (const double value : {log(x), log10(x), log1p(x), exp(x), expm1(-x), tanh(unit), cbrt(x), atan2(x, 1.5),
                               asin(unit), acos(unit), sine_cosine(x).sine, sine_cosine(x).cosine}) {
      add(value);
    }
  }
  EXPECT_EQ(hash, 0x8be709c68eaa5138U) << std::hex << hash;
}

}  // namespace
}  // namespace consimd::elementary
