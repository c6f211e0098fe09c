// TEASER: rotation and translation one after the other, from the correspondences that all agree in length.
// H. Yang, J. Shi, L. Carlone, "TEASER: Fast and Certifiable Point Cloud Registration", T-RO 2021.
#pragma once

#include <cstddef>
#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/gnc_rotation.hpp>
#include <consimd/solvers/maximum_clique.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

struct TeaserOptions {
  /// tau, the paper's beta: the largest residual of an inlier, caller's unit; finite and > 0.
  double noise_bound = 0.0;
  std::uint64_t seed = 1;  ///< of the significance test, and of the scale's voters; the estimate itself draws nothing
  /// Find the scale of the source as well (see scale_voting.hpp).
  bool estimate_scale = false;
  /// The correspondences that go on, of the graph whose edges are pairs with | |p_j-p_i| - |q_j-q_i| | < 2 tau.
  enum class Selection : std::uint8_t {
    maximum_clique,  ///< the largest set that agrees pairwise
    maximum_core,    ///< the vertices of largest core number: no search, but more outliers among them
    everything,
  } selection = Selection::maximum_clique;
  /// Nodes of the clique search at most, and its work (see MaximumCliqueOptions), which bounds the time where many
  /// pairs agree by chance: by some two seconds of one core. When one of them ends before the proof the largest clique
  /// so far is taken, and the status is budget_exhausted, unless what the pose does not explain holds no clique that
  /// could make another as good. 0 nodes: the greedy heuristic alone.
  std::uint64_t max_nodes = 200'000;
  std::uint64_t max_work = MaximumCliqueOptions().max_work;
  GncRotationOptions::Pairs rotation_pairs = GncRotationOptions::Pairs::chain;
  /// Bring the pose to the statistical limit with all correspondences, as the default solver does. The paper's own
  /// translation, a vote on each axis alone, is several times less accurate; false returns it, without a covariance.
  bool refine = true;
  /// Memory for the graph, 1.1 MB for 3000 correspondences, 12.6 MB for 10 000; the clique search takes up to twice as
  /// much again. A graph that needs more is an error.
  std::size_t matrix_budget_bytes = std::size_t{64} << 20;
  /// Noise bounds that the given one was chosen from by looking at the data, >= 1: their number counts in the
  /// significance.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// Registers with TEASER, at scale 1 or at the scale that pairs vote for: pairs that agree in length, their maximum
/// clique, graduated non-convexity for the rotation, adaptive voting for the translation. A large clique of what the
/// pose does not explain tells whether another motion has as much support. The clique search is parallel in the
/// caller's oneTBB arena; the result has the same bits for any number of threads and every ISA. Throws
/// std::invalid_argument on a bad option, or if the graph exceeds its budget.
[[nodiscard]] Registration register_teaser(const Correspondences& correspondences, const TeaserOptions& options);

}  // namespace consimd
