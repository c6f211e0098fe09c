// What the correspondences of a registration give without a motion: poses are held against it.
#pragma once

#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "verdict/coherence.hpp"
#include "verdict/strata.hpp"

namespace consimd::detail {

/// Measured once, for any number of poses.
class Background {
 public:
  /// `noise_bound`: caller's unit. Keeps a view of the correspondences.
  Background(const Correspondences& correspondences, double noise_bound);

  /// ln of the number of poses supported as well as this one that pairing gives, at random or within the strata that
  /// explain the pose best.
  [[nodiscard]] double log_false_poses(const WorkingPose& pose) const;

 private:
  struct Kept {
    Strata strata;
    PairingHits lengths;
  };

  CorrespondenceView view_;
  double noise_bound_;
  std::vector<Kept> kept_;
  Coherence coherence_;
};

}  // namespace consimd::detail
