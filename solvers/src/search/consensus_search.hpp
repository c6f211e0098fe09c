// The consensus search, that of the default TCF: rounds of seeds, their sets, the poses of these.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/significance.hpp>
#include <consimd/solvers/stop_condition.hpp>

#include "search/seed_sets.hpp"
#include "search/set_poses.hpp"
#include "search/tcf_tuning.hpp"
#include "support/best_poses.hpp"

namespace consimd::detail {

struct ConsensusSearchOptions {
  double noise_bound = 0.0;  ///< caller's unit
  std::uint64_t seed = 1;
  double confidence = 0.99;  ///< that a seed of the pose with the largest support has been drawn
  std::uint32_t max_seeds = 10'000;
  std::size_t matrix_budget_bytes = std::size_t{64} << 20;
  TcfTuning tuning = {};
  StopCondition stop = {};
  bool settles = true;  ///< looks whether the best pose is beyond doubt, so that only rivals are searched for then
};

class ConsensusSearch {
 public:
  /// Keeps a reference to the correspondences.
  ConsensusSearch(const Correspondences& correspondences, const ConsensusSearchOptions& options);

  /// Starts from a pose that is known already, locally optimised.
  void offer(const WorkingPose& pose);

  /// Draws rounds of seeds until one of the best pose's supporters has been among them with the wanted confidence; or,
  /// with care, again until one of any pose that may become the best or its rival has been, with more confidence. Where
  /// few pairs of rows agree and many seeds are needed, it looks at all sets instead, after which there is nothing more
  /// to do.
  void run(bool careful);

  /// The pose of highest score so far, locally optimised; support.count below 3: none.
  [[nodiscard]] const PoseCandidate& best() const noexcept { return poses_.best(); }
  /// The same, and the best pose that is another motion, not optimised: one with at least kRivalShare of the best
  /// pose's support is met with about the confidence that the best one is.
  [[nodiscard]] const BestPoses& poses() const noexcept { return poses_; }
  /// The pruned set that it came from, ascending.
  [[nodiscard]] const std::vector<std::uint32_t>& best_set() const noexcept { return best_set_; }
  /// Whether the seeds drawn suffice for the wanted confidence.
  [[nodiscard]] bool confident() const;
  /// Whether all sets have been looked at.
  [[nodiscard]] bool exhaustive() const noexcept { return exhaustive_; }
  /// Whether the options' condition has ended it.
  [[nodiscard]] bool stopped() const noexcept { return stopped_; }

  /// The significance of the best pose, once a glance leaves hardly a doubt: only rivals may still turn up then.
  [[nodiscard]] const std::optional<Significance>& settled() const noexcept { return settled_; }

  [[nodiscard]] const SeedSets& sets() const noexcept { return sets_; }
  [[nodiscard]] std::uint64_t minimal_fits() const noexcept { return minimal_fits_; }
  /// Rows whose sets have been looked at.
  [[nodiscard]] std::uint64_t seeds() const noexcept { return exhaustive_ ? correspondences_.size() : sets_.drawn(); }
  [[nodiscard]] double two_point_seconds() const noexcept { return sets_.two_point_seconds() + all_sets_seconds_; }
  [[nodiscard]] double three_point_seconds() const noexcept { return three_point_seconds_; }

 private:
  [[nodiscard]] std::uint64_t seeds_needed() const;
  [[nodiscard]] std::uint64_t careful_seeds() const;
  [[nodiscard]] std::uint32_t support_of_interest() const;
  void draw_rounds(bool careful);
  void fit_round(std::span<const std::uint32_t> positions);
  [[nodiscard]] double seeds_for_all() const;
  void look_at_all_sets();
  void look_for_repeated_rival();
  void settle();
  // A set whose pose is wanted, and what keys its random numbers.
  struct SetToFit {
    const std::vector<std::uint32_t>* rows;
    std::uint64_t hypothesis;
  };
  void fit_sets(std::span<const SetToFit> sets);

  const Correspondences& correspondences_;
  ConsensusSearchOptions options_;
  SeedSets sets_;
  BestPoses poses_;
  std::vector<std::uint32_t> best_set_;
  std::optional<Significance> settled_;
  std::vector<PoseCandidate> candidates_;
  tbb::enumerable_thread_specific<PoseScratch> scratch_;
  double all_sets_seconds_ = 0.0;
  double three_point_seconds_ = 0.0;
  std::uint64_t minimal_fits_ = 0;
  bool tried_all_ = false;  // to look at all sets
  bool exhaustive_ = false;
  bool stopped_ = false;
};

}  // namespace consimd::detail
