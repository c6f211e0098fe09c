// Points that move onto a cloud, each with the point of it that is nearest. No standard-library containers here: the
// ISA-specific sources include this file.
#pragma once

#include <cstddef>
#include <cstdint>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Up to kSize moving points. Normals are read by PairMetric::gicp alone.
struct alignas(64) PairBlock {
  static constexpr std::size_t kSize = 512;
  float from[3][kSize];       ///< where the points are before the motion, working frame of their cloud
  float normals[3][kSize];    ///< theirs, before the motion; unit length, or NaN
  float looked[3][kSize];     ///< where each was when its nearest point was looked for
  float trust[kSize];         ///< how far a point may be from `looked` and still have the same nearest point
  float points[3][kSize];     ///< the moved points, working frame of the target
  std::uint32_t rows[kSize];  ///< the nearest point of the target, target.size() where there is none
};

/// p moves to linear p + shift, from one working frame to another; the numbers are the sums of two in single precision,
/// so that a motion smaller than one's rounding is not lost. Rows one after the other.
struct WorkingMotion {
  float linear[9];
  float shift[3];
  float linear_rest[9];
  float shift_rest[3];
};

/// What is made small of e = x - q, x a moved point and q the nearest one.
enum class PairMetric : std::uint8_t {
  point,  ///< e^T e
  plane,  ///< (n^T e)^2, n the normal at q
  /// e^T M e, M = 2 k (2 I - (1 - k) (n n^T + m m^T))^-1, m the moved normal at x and k = 1e-3: the inverse sum of
  /// covariances of k along the normals and 1 across, in units of its largest eigenvalue for equal normals (Segal,
  /// Haehnel, Thrun, "Generalized-ICP", RSS 2009, section III-C).
  gicp,
};

/// What is made small of the pairs, and which of them count. Lengths are those of the target's working frame.
struct PairProblem {
  PairMetric metric;
  float rotation[9];   ///< of the moved normals, rows one after the other
  float centre[3];     ///< about which rotations are taken
  float max_distance;  ///< points further apart are no pair
  float scale;         ///< deviation of a residual
};

/// Sums over pairs with residual r, r^2 = e^T M e, and weight w = 1 / (1 + (r / (2.3849 scale))^2), for the motion of x
/// to x + omega cross a + tau, a = x - centre. J = (-[a]x, I) is the derivative by (omega, tau).
struct PairEquations {
  float normal[21];      ///< lower triangle of sum w J^T M J, row by row
  float score[6];        ///< sum w J^T M e
  float weight;          ///< sum w
  float spread;          ///< sum w |a|^2
  float squared_score;   ///< sum w^2 r^2
  float slope;           ///< sum w (2 w - 1), by which w r changes with r
  float squared_length;  ///< sum r^2 of `plane`, else of |e|^2
  std::uint32_t pairs;
};

}  // namespace consimd
