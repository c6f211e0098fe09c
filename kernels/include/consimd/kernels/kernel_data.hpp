// The plain structs that kernels take and return. No standard-library containers here: the ISA-specific sources include
// this file.
#pragma once

#include <cstdint>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Two correspondences that a two-point hypothesis is drawn from.
struct IndexPair {
  std::uint32_t first;
  std::uint32_t second;
};

/// Three correspondences that a minimal pose hypothesis is drawn from.
struct IndexTriple {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t third;
};

/// A rigid motion q' = R p' + t in the working frame of a `Correspondences`, single precision. `rotation` is row-major.
struct WorkingPose {
  float rotation[9];
  float translation[3];
};

/// Support of a pose: the number of residuals below the bound, and their truncated quadratic score sum(1 - r^2 /
/// bound^2), the MSAC score, computed as count - sum(r^2) / bound^2. The sum is taken in 16 interleaved partial sums
/// joined in one fixed order: the same bits on every ISA.
struct PoseSupport {
  std::uint32_t count;
  float score;
};

/// Sums over correspondences j with weights w_j, in the working frame: all that a weighted rigid fit (Kabsch, Horn)
/// needs.
struct RigidMoments {
  double weight;             ///< sum w
  double source[3];          ///< sum w p
  double target[3];          ///< sum w q
  double cross[9];           ///< sum w q p^T, row-major: cross[3 a + b] = sum w q_a p_b
  double source_scatter[6];  ///< sum w p p^T: xx, xy, xz, yy, yz, zz
  double residual;           ///< sum w r^2 under the pose that gave the weights (robust_moments only, else 0)
};

/// How the weight of a correspondence falls with its residual r.
enum class WeightFunction : std::uint8_t {
  truncated,  ///< 1
  cauchy,     ///< 1 / (1 + r^2 / scale^2), the weight of the scale-adaptive Cauchy IRLS
  /// 1 / (y (1 + odds y^exponent)), y = 1 + r^2 / (2 exponent scale^2): maximum likelihood for inliers of density ~
  /// y^-exponent, a Student distribution of 2 exponent - 3 degrees of freedom, among uniform outliers. Exponent 64 is a
  /// Gaussian of deviation `scale` an axis but for a percent; exponent 2 has the tails of a Cauchy distribution.
  student_uniform,
};

/// A weight function with its parameters. Every weight is 0 where r >= cutoff.
struct RobustWeight {
  WeightFunction function = WeightFunction::truncated;
  double scale = 1.0;           ///< caller's unit, > 0
  double cutoff = 1.0;          ///< caller's unit, > 0
  double odds = 0.0;            ///< outlier density over inlier density at r = 0, >= 0; student_uniform only
  std::uint32_t exponent = 64;  ///< a power of two from 2 to 64; student_uniform only
};

}  // namespace consimd
