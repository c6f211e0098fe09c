// Poses tried at many noise bounds, and looks at them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/solvers/stop_condition.hpp>

#include "verdict/background.hpp"
#include "verdict/kept_structure.hpp"

namespace consimd::detail {

inline constexpr std::uint32_t kBounds = 10;
/// Among so many rows no search and no look takes long.
inline constexpr std::size_t kFewRows = 1024;
/// Seeds of a search among all of these, or of more.
inline constexpr std::uint32_t kSeeds = 1024;

/// log10 by which many bounds raise the number of false poses.
inline double penalty() { return elementary::log10(kBounds); }

/// A pose at one bound.
struct Attempt {
  double bound;
  WorkingPose pose;
  double log10_false_poses = 0.0;
};

/// Of equally significant attempts that at the smaller bound is the better one.
inline std::pair<double, double> rank(const Attempt& attempt) { return {attempt.log10_false_poses, attempt.bound}; }

/// A glance at an attempt; many bounds count.
double glance(const Correspondences& correspondences, const Attempt& attempt);

/// Close looks at poses. What they are held against is measured once a bound, and rows are cut into strata once.
class CloseLooks {
 public:
  /// Keeps a reference to the correspondences.
  explicit CloseLooks(const Correspondences& correspondences);

  /// Where that is not below `enough` there may be more.
  [[nodiscard]] double log10_false_poses(const WorkingPose& pose, double bound, double enough = 0.0);

  [[nodiscard]] bool are_cheap() const { return correspondences_.size() <= kFewRows; }

  /// Whether a registration would find the pose significant, beside what its runner-up may reach.
  [[nodiscard]] bool is_significant(const WorkingPose& pose, double bound);

 private:
  const Correspondences& correspondences_;
  std::shared_ptr<const KeptStructure> kept_;
  std::vector<std::pair<double, Background>> backgrounds_;
};

/// What a search takes upon itself.
struct Effort {
  std::uint32_t seeds;
  /// Bounds tried past the most significant one before it is believed to be that, if a glance leaves no doubt, or in
  /// doubt too: what matchers keep, which pairing at random knows nothing of, may be more significant at other bounds.
  std::uint32_t bounds_past;
  bool stops_in_doubt = false;
  std::size_t glances = 3;   ///< at the most significant attempts: what a glance finds of one may be too little
  bool independent = false;  ///< among rows that tell of different places, where that are clearly fewer than all
  bool careful = false;
};
/// On some of the rows.
inline constexpr Effort kOnSample{.seeds = 256, .bounds_past = 2, .stops_in_doubt = true};

/// What searches among all rows, each if the former has found nothing, take upon themselves.
std::vector<Effort> efforts(std::size_t rows);

/// The attempts of a search, at some of the bounds.
class BoundAttempts {
 public:
  /// Keeps a reference to the correspondences.
  BoundAttempts(const Correspondences& correspondences, double largest_bound, std::uint64_t seed, const Effort& effort,
                const StopCondition& stop)
      : correspondences_(correspondences), seed_(seed), effort_(effort), stop_(stop) {
    run(largest_bound);
  }

  /// The best pose and its runner-up at each bound, with the value of a plain look.
  [[nodiscard]] const std::vector<Attempt>& tried() const { return tried_; }
  /// One that a glance leaves no doubt of, with the value of that.
  [[nodiscard]] const std::optional<Attempt>& beyond_doubt() const { return beyond_doubt_; }

 private:
  void run(double largest_bound);
  double try_bound(const Correspondences& searched, double bound);
  void glance_at_best();

  const Correspondences& correspondences_;
  std::uint64_t seed_;
  Effort effort_;
  StopCondition stop_;
  std::vector<WorkingPose> known_;  // the poses at the last bound
  std::vector<Attempt> tried_;
  std::optional<Attempt> beyond_doubt_;
};

}  // namespace consimd::detail
