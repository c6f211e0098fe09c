#include <consimd/kernels/elementary_functions.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

namespace consimd::elementary {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A number as a sum of two. The leading parts of the constants have so few bits that their products with the integers
// below are exact.
struct Sum {
  double high;
  double low;
};

constexpr Sum kLn2{0x1.62e42fefa2p-1, 0x1.9ef35793c7673p-41};  // 40 bits
constexpr Sum kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
constexpr Sum kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

// Exact: O. Møller, "Quasi double-precision in floating point addition", BIT 5, 1965.
Sum exact_sum(double a, double b) noexcept {
  const double high = a + b;
  const double of_b = high - a;
  return {high, (a - (high - of_b)) + (b - of_b)};
}

// Sum of c[k] x^k. Even and odd terms by themselves, so that half as many operations wait for one another.
template <std::size_t N>
double series(double x, const std::array<double, N>& c) noexcept {
  static_assert(N % 2 == 0);
  const double squared = x * x;
  double even = c[N - 2];
  double odd = c[N - 1];
  for (std::size_t k = N - 2; k != 0; k -= 2) {
    even = even * squared + c[k - 2];
    odd = odd * squared + c[k - 1];
  }
  return even + x * odd;
}

// 1 / n! for n = first, first + step, ...; the signs alternate where `alternate` is -1.
template <std::size_t N>
constexpr std::array<double, N> inverse_factorials(int first, int step, double alternate) noexcept {
  std::array<double, N> result{};
  double factorial = 1.0;  // exact up to 22!
  int n = 1;
  double sign = 1.0;
  for (double& value : result) {
    while (n < first) factorial *= ++n;
    value = sign / factorial;
    first += step;
    sign *= alternate;
  }
  return result;
}

constexpr int kMantissaBits = 52;
constexpr int kBias = 1023;

// 2^exponent, of a normal number.
double power_of_two(int exponent) noexcept {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + kBias) << kMantissaBits);
}

struct Scaled {
  double mantissa;  // in [1, 2)
  int exponent;
};

// Of a positive, finite number.
Scaled scaled(double x) noexcept {
  int exponent = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 0x1p54;
    exponent = -54;
  }
  const auto bits = std::bit_cast<std::uint64_t>(x);
  exponent += static_cast<int>(bits >> kMantissaBits) - kBias;
  constexpr std::uint64_t kMantissa = (std::uint64_t{1} << kMantissaBits) - 1;
  return {std::bit_cast<double>((bits & kMantissa) | std::bit_cast<std::uint64_t>(1.0)), exponent};
}

// log(1 + f) = 2 atanh(s) with s = f / (2 + f), |s| < 0.172: the series up to s^23 leaves 1e-18 of it. 2 s = f - s f.
constexpr auto kArtanh = [] {
  std::array<double, 12> c{};
  for (std::size_t k = 1; k < c.size(); ++k) c[k] = 2.0 / (2.0 * static_cast<double>(k) + 1.0);
  return c;
}();

// exp(r) = 1 + r + r^2 / 2 + ..., |r| <= ln(2) / 2: up to r^15.
constexpr auto kExponential = inverse_factorials<14>(2, 1, 1.0);
// sin(r) and cos(r), |r| <= pi / 4: up to r^17 and r^18.
constexpr auto kSine = inverse_factorials<8>(3, 2, -1.0);
constexpr auto kCosine = inverse_factorials<8>(4, 2, -1.0);

// log(x) of a positive, finite number.
Sum logarithm(double x) noexcept {
  auto [mantissa, exponent] = scaled(x);
  if (mantissa > std::numbers::sqrt2) {
    mantissa *= 0.5;
    ++exponent;
  }
  const double f = mantissa - 1.0;
  const double s = f / (2.0 + f);
  const double rest = s * (f - series(s * s, kArtanh));
  const Sum leading = exact_sum(exponent * kLn2.high, f);
  return {leading.high, leading.low - (rest - exponent * kLn2.low)};
}

struct ReducedExponent {
  double rest;        // exp(r) - 1, of the rest r with |r| <= ln(2) / 2
  double correction;  // what `rest` lacks
  int doublings;
};

// Of finite x with |x| < 800.
ReducedExponent reduce(double x) noexcept {
  const double doublings = std::floor(x * std::numbers::log2e + 0.5);
  const double high = x - doublings * kLn2.high;
  const double low = doublings * kLn2.low;
  const double r = high - low;
  const Sum rest = exact_sum(r, r * r * series(r, kExponential) + ((high - r) - low));
  return {rest.high, rest.low, static_cast<int>(doublings)};
}

// x 2^exponent, in two steps since the power itself may not be a normal number.
double times_power_of_two(double x, int exponent) noexcept {
  const int half = exponent / 2;
  return x * power_of_two(half) * power_of_two(exponent - half);
}

// The sum of `a` and `b`, with b added to or taken from a.
double sum(const Sum& a, double sign, const Sum& b) noexcept {
  const Sum high = exact_sum(a.high, sign * b.high);
  return high.high + (high.low + (a.low + sign * b.low));
}

// atan(k / 8).
constexpr std::array<Sum, 9> kArctangents{{{0.0, 0.0},
                                           {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                           {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                           {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                           {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                           {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                           {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                           {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                           {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}}};

// atan(r) = r - r^3 / 3 + ..., |r| < 1/8: up to r^19, and without the first term.
constexpr auto kArctangent = [] {
  std::array<double, 10> c{};
  for (std::size_t k = 1; k < c.size(); ++k) c[k] = (k % 2 == 0 ? 1.0 : -1.0) / (2.0 * static_cast<double>(k) + 1.0);
  return c;
}();

// atan(y / x), 0 <= y <= x, 0 < x, both finite, as a sum: atan(c) + atan((y - c x) / (x + c y)) with c = k / 8.
Sum arctangent(double y, double x) noexcept {
  const double quotient = y / x;
  if (quotient < 0x1p-27) return {quotient, 0.0};  // its cube is beyond the last place
  const auto k = quotient < 0.125 ? std::size_t{0} : static_cast<std::size_t>(std::floor(8.0 * quotient + 0.5));
  double r = quotient;
  if (k != 0) {
    // Scaled, so that nothing over- or underflows; c times each half of x is exact.
    const int exponent = scaled(x).exponent;
    x = times_power_of_two(x, -exponent);
    y = times_power_of_two(y, -exponent);
    const double c = static_cast<double>(k) / 8.0;
    const double high = static_cast<double>(static_cast<float>(x));
    r = ((y - c * high) - c * (x - high)) / (x + c * y);
  }
  const Sum& at = kArctangents[k];
  const double rest = r * series(r * r, kArctangent) + at.low;
  const Sum leading = exact_sum(at.high, r);
  return {leading.high, leading.low + rest};
}

}  // namespace

double log(double x) noexcept {
  if (!(x > 0.0)) return x == 0.0 ? -kInfinity : kNaN;
  if (x == kInfinity) return x;
  const Sum result = logarithm(x);
  return result.high + result.low;
}

double log10(double x) noexcept {
  if (!(x > 0.0)) return x == 0.0 ? -kInfinity : kNaN;
  if (x == kInfinity) return x;
  const Sum natural = logarithm(x);
  const Sum sum = exact_sum(natural.high, natural.low);
  // The leading parts have so few bits that their product is exact.
  constexpr Sum kLog10E{0x1.bcb7b1p-2, 0x1.49b9438ca9aaep-28};
  const double leading = static_cast<double>(static_cast<float>(sum.high));
  const double rest = (sum.high - leading) + sum.low;
  return leading * kLog10E.high + (leading * kLog10E.low + rest * std::numbers::log10e);
}

double log1p(double x) noexcept {
  if (std::abs(x) < 0x1p-54) return x;
  const Sum one_more = exact_sum(1.0, x);
  if (!(one_more.high > 0.0) || one_more.high == kInfinity) return log(one_more.high);
  return log(one_more.high) + one_more.low / one_more.high;
}

double exp(double x) noexcept {
  if (std::isnan(x)) return x;
  if (x > 709.8) return kInfinity;  // the logarithm of the largest number is 709.78...
  if (x < -745.2) return 0.0;       // that of half the smallest one is -745.13...
  const ReducedExponent reduced = reduce(x);
  return times_power_of_two(1.0 + reduced.rest, reduced.doublings);
}

double expm1(double x) noexcept {
  if (std::abs(x) < 0x1p-54) return x;
  if (!(x < 40.0)) return exp(x);  // 1 is beyond the last place
  if (x < -40.0) return -1.0;
  const ReducedExponent reduced = reduce(x);
  const double power = power_of_two(reduced.doublings);
  const Sum leading = exact_sum(power - 1.0, power * reduced.rest);
  return leading.high + (leading.low + power * reduced.correction);
}

double tanh(double x) noexcept {
  if (std::isnan(x) || x == 0.0) return x;
  const double size = std::abs(x);
  const double grown = expm1(2.0 * std::min(size, 20.0));  // 1 - tanh(20) is beyond the last place
  return std::copysign(grown / (grown + 2.0), x);
}

double cbrt(double x) noexcept {
  if (x == 0.0 || !std::isfinite(x)) return x;
  auto [mantissa, exponent] = scaled(std::abs(x));
  // Divided by three towards minus infinity: the rest is 0, 1 or 2.
  const int third = (exponent + 3 * 400) / 3 - 400;
  mantissa *= power_of_two(exponent - 3 * third);  // in [1, 8)
  // Halley's steps: each takes a relative error e to 2/3 e^3; the guess is within 0.1.
  double root = 0.9 + mantissa * 0.14;
  for (int step = 0; step < 3; ++step) {
    const double cube = root * root * root;
    root -= root * ((cube - mantissa) / (2.0 * cube + mantissa));
  }
  return std::copysign(root * power_of_two(third), x);
}

SineCosine sine_cosine(double x) noexcept {
  constexpr double kLargest = 0x1p20;
  if (!(std::abs(x) <= kLargest)) return {kNaN, kNaN};
  if (std::abs(x) < 0x1p-27) return {x, 1.0};  // the cube and the square are beyond the last place
  // Three parts of pi / 2, the first two of 32 bits, so that their products with the number of quarter turns are exact:
  // W. Cody, W. Waite, "Software Manual for the Elementary Functions", 1980.
  constexpr double kFirst = 0x1.921fb544p+0, kSecond = 0x1.0b4611a6p-34, kThird = 0x1.3198a2e037073p-69;
  const double quarters = std::floor(x * (2.0 * std::numbers::inv_pi) + 0.5);
  const Sum rest = exact_sum(x - quarters * kFirst, -quarters * kSecond);
  const double third = quarters * kThird - rest.low;
  const double r = rest.high - third;
  const double low = (rest.high - r) - third;

  const double squared = r * r;
  const double sine = r - (squared * r * series(squared, kSine) - low);
  const double half = 0.5 * squared;
  const double leading = 1.0 - half;
  const double cosine = leading + (((1.0 - leading) - half) + (squared * squared * series(squared, kCosine) - r * low));
  switch (static_cast<int>(quarters) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

double atan2(double y, double x) noexcept {
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  double across = std::abs(x);
  double up = std::abs(y);
  if (across == kInfinity || up == kInfinity) {
    across = across == kInfinity ? 1.0 : 0.0;
    up = up == kInfinity ? 1.0 : 0.0;
  }
  const bool backward = std::signbit(x);
  double angle = 0.0;
  if (up > across) {
    angle = sum(kHalfPi, backward ? 1.0 : -1.0, arctangent(across, up));
  } else {
    const Sum forward = across == 0.0 ? Sum{0.0, 0.0} : arctangent(up, across);
    angle = backward ? sum(kPi, -1.0, forward) : forward.high + forward.low;
  }
  return std::copysign(angle, y);
}

double asin(double x) noexcept { return atan2(x, std::sqrt((1.0 - x) * (1.0 + x))); }

double acos(double x) noexcept { return atan2(std::sqrt((1.0 - x) * (1.0 + x)), x); }

}  // namespace consimd::elementary
