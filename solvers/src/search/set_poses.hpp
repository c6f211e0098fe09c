// Three-point part of the default TCF: poses of pruned consensus sets.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "search/tcf_tuning.hpp"
#include "support/pose_candidate.hpp"

namespace consimd::detail {

/// Scratch of `pose_of_set`, kept between calls.
struct PoseScratch {
  Correspondences subset;
  std::vector<IndexTriple> triples;
  std::vector<WorkingPose> poses;
  std::vector<PoseSupport> support;
};

/// The best of `tuning.triples` minimal fits to `set` (rows of `correspondences`, at least three) by their score within
/// the set, and its refit to the members it aligns; whichever of the two has the better score among all
/// correspondences. `hypothesis` keys the draws. Its support is zero when the set determines no
/// pose, or when the first fits show that there is none of `support_to_beat`.
PoseCandidate pose_of_set(const Correspondences& correspondences, const std::vector<std::uint32_t>& set,
                          double noise_bound, std::uint64_t seed, std::uint64_t hypothesis,
                          std::uint32_t support_to_beat, const ThreePointTuning& tuning, PoseScratch& scratch);

/// Largest score within `set` (rows of `correspondences`) of the minimal poses of its first two rows and each of
/// `glances` of the others.
float score_at_a_glance(const Correspondences& correspondences, std::span<const std::uint32_t> set, double noise_bound,
                        std::size_t glances, PoseScratch& scratch);

}  // namespace consimd::detail
