// Elementary functions with the same bits on every processor and with every C library.
#pragma once

#include <consimd/kernels/export.hpp>

namespace consimd {

/// The C library's logarithms, powers and angles round in their own way from one library, and from one processor, to
/// another: glibc picks variants with fused multiply-adds at run time. Whatever reaches a result calls these instead.
/// They are made of + - * / and sqrt, which IEEE 754 rounds in one way, and compiled without contraction.
///
/// Errors are stated in units in the last place of the exact result (ULP) where that is a normal number; a subnormal
/// one is off by two spacings at most. Infinities, zeros and their signs are as in C (annex F); of NaN, and where a
/// function is not defined, the result is NaN. They do not set errno.
namespace CONSIMD_EXPORT elementary {

/// Natural logarithm, within 1 ULP.
[[nodiscard]] double log(double x) noexcept;

/// Logarithm to base 10, within 1 ULP; exact where it is an integer.
[[nodiscard]] double log10(double x) noexcept;

/// log(1 + x), within 2 ULP.
[[nodiscard]] double log1p(double x) noexcept;

/// Exponential, within 1 ULP.
[[nodiscard]] double exp(double x) noexcept;

/// exp(x) - 1, within 2 ULP.
[[nodiscard]] double expm1(double x) noexcept;

/// Hyperbolic tangent, within 3 ULP.
[[nodiscard]] double tanh(double x) noexcept;

/// Cube root, within 1 ULP.
[[nodiscard]] double cbrt(double x) noexcept;

struct SineCosine {
  double sine;
  double cosine;
};

/// Sine and cosine of `x` in radians, each within 1 ULP, for |x| <= 2^20; NaN beyond, where more digits of pi were
/// needed.
[[nodiscard]] SineCosine sine_cosine(double x) noexcept;

/// Angle of (x, y) from the x axis in radians, in [-pi, pi], within 2 ULP.
[[nodiscard]] double atan2(double y, double x) noexcept;

/// Inverse sine in radians, in [-pi/2, pi/2], within 3 ULP.
[[nodiscard]] double asin(double x) noexcept;

/// Inverse cosine in radians, in [0, pi], within 3 ULP.
[[nodiscard]] double acos(double x) noexcept;

}  // namespace elementary
}  // namespace consimd
