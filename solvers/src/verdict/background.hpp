// What the correspondences of a registration give without a motion: poses are held against it.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "verdict/coherence.hpp"
#include "verdict/kept_structure.hpp"
#include "verdict/lookalikes.hpp"
#include "verdict/strata.hpp"

namespace consimd::detail {

/// Measured once, for any number of poses, each of which is looked at once; and structure only when a pose is first
/// supported by more than random pairing, and than the structure before it, explains. Not for several threads at a
/// time.
class Background {
 public:
  /// `noise_bound`: caller's unit. Keeps a pointer to the correspondences. `kept`: of these, from a background at
  /// another bound.
  Background(const Correspondences& correspondences, double noise_bound,
             std::shared_ptr<const KeptStructure> kept = nullptr);

  /// ln of the number of poses supported as well as this one that pairing gives, at random or within the strata that
  /// explain the pose best. Where it is not below `enough` there may be more: as soon as any of them gives so many,
  /// the others are not looked at, but for those that other threads look at.
  [[nodiscard]] double log_false_poses(const WorkingPose& pose, double enough = 0.0) const;

 private:
  // Rows among which pairings are exchanged, and how often that makes lengths agree.
  struct Kept {
    Strata strata;
    PairingHits lengths;
  };
  struct Alike {
    Lookalikes lookalikes;
    PairingHits lengths;
  };
  struct Told {
    WorkingPose pose;
    double log_false_poses;
    bool is_all;
  };
  [[nodiscard]] const Alike& lookalikes() const;
  [[nodiscard]] const std::vector<Kept>& kind(std::size_t k) const;
  [[nodiscard]] double measured(const WorkingPose& pose, double enough) const;

  const Correspondences* correspondences_;
  double noise_bound_;
  Coherence coherence_;
  std::shared_ptr<const KeptStructure> kept_;
  mutable std::optional<Alike> lookalikes_;
  mutable std::vector<std::vector<Kept>> kinds_;
  mutable std::vector<Told> told_;  // a registration comes back to the same few poses
};

}  // namespace consimd::detail
