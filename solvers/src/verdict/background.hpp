// What the correspondences of a registration give without a motion: poses are held against it.
#pragma once

#include <optional>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "verdict/coherence.hpp"
#include "verdict/lookalikes.hpp"
#include "verdict/strata.hpp"

namespace consimd::detail {

/// Measured once, for any number of poses, each of which is looked at once; and structure only when a pose is first
/// supported by more than random pairing explains. Not for several threads at a time.
class Background {
 public:
  /// `noise_bound`: caller's unit. Keeps a pointer to the correspondences.
  Background(const Correspondences& correspondences, double noise_bound);

  /// ln of the number of poses supported as well as this one that pairing gives, at random or within the strata that
  /// explain the pose best; 0 or more as soon as any of them explains it.
  [[nodiscard]] double log_false_poses(const WorkingPose& pose) const;

 private:
  // Rows among which pairings are exchanged, and how often that makes lengths agree.
  struct Kept {
    Strata strata;
    PairingHits lengths;
  };
  struct Structure {
    std::vector<Kept> kept;
    Lookalikes lookalikes;
    PairingHits lookalike_lengths;
  };
  struct Told {
    WorkingPose pose;
    double log_false_poses;
  };
  [[nodiscard]] const Structure& structure() const;
  [[nodiscard]] double measured(const WorkingPose& pose) const;

  const Correspondences* correspondences_;
  double noise_bound_;
  Coherence coherence_;
  mutable std::optional<Structure> structure_;
  mutable std::vector<Told> told_;  // a registration comes back to the same few poses
};

}  // namespace consimd::detail
