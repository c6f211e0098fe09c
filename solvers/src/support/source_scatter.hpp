// Scatter of the source points that moments were taken of, working frame.
#pragma once

#include <Eigen/Core>

#include <consimd/kernels/rigid_moments.hpp>

namespace consimd::detail {

/// Weighted sum of p p^T.
inline Eigen::Matrix3d source_scatter(const RigidMoments& moments) {
  const double* s = moments.source_scatter;
  Eigen::Matrix3d scatter;
  scatter << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return scatter;
}

/// The same about the weighted mean of the points.
inline Eigen::Matrix3d central_source_scatter(const RigidMoments& moments) {
  const Eigen::Vector3d mean = Eigen::Map<const Eigen::Vector3d>(moments.source) / moments.weight;
  return source_scatter(moments) - moments.weight * mean * mean.transpose();
}

}  // namespace consimd::detail
