// When two poses are one motion.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::detail {

/// Two poses that take the supporters of the first to within so many noise bounds of each other, root mean square, are
/// one motion.
inline constexpr double kSameMotion = 2.0;

/// A pose with where its supporters are.
class SupportedMotion {
 public:
  /// One that no pose is the same as.
  SupportedMotion() = default;
  SupportedMotion(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound);

  [[nodiscard]] bool is_same(const WorkingPose& other) const;

 private:
  RigidTransform pose_ = RigidTransform::Identity();
  RigidMoments supporters_{};
  double limit_ = 0.0;  // working frame
};

}  // namespace consimd::detail
