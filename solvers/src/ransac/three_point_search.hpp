// The search of `ransac`: samples of three, the poses of those whose triangles agree, the best of these.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/solvers/ransac.hpp>

#include "support/best_poses.hpp"

namespace consimd::detail {

class ThreePointSearch {
 public:
  /// Keeps references to both. At least three correspondences.
  ThreePointSearch(const Correspondences& correspondences, const RansacOptions& options);

  /// Draws samples until one of the best pose's supporters has been among them with the wanted confidence.
  void run();

  /// The best pose and its runner-up; support.count below 3: none.
  [[nodiscard]] const BestPoses& poses() const noexcept { return poses_; }
  [[nodiscard]] std::uint64_t iterations() const noexcept { return iterations_; }
  /// Whether the samples drawn suffice for the wanted confidence, or are as many as were asked for.
  [[nodiscard]] bool confident() const { return iterations_ >= iterations_needed(); }
  /// Whether the options' condition has ended it.
  [[nodiscard]] bool stopped() const noexcept { return stopped_; }
  /// Rows that agree in length with each of the three that the best pose came from, ascending.
  [[nodiscard]] std::vector<std::uint32_t> best_set() const;

 private:
  [[nodiscard]] std::uint64_t iterations_needed() const;
  [[nodiscard]] bool worth_fitting(const IndexTriple& sample) const;
  void draw(std::uint64_t count);
  void fit();
  void score(std::span<const WorkingPose> poses, std::span<PoseSupport> support) const;
  void offer(std::size_t position);

  const Correspondences& correspondences_;
  const RansacOptions& options_;
  float squared_tolerance_;  // of lengths, working frame
  Correspondences preview_;  // a few of the rows
  BestPoses poses_;
  IndexTriple best_sample_{};
  float highest_sample_score_ = 0.0F;  // before local optimisation
  std::uint64_t iterations_ = 0;
  std::uint64_t wanted_;  // iterations, as far as is known
  bool stopped_ = false;

  // Samples of a round.
  std::vector<IndexTriple> drawn_;
  std::vector<std::uint8_t> worth_;
  // Those worth fitting.
  std::vector<IndexTriple> samples_;
  std::vector<std::uint64_t> sample_iterations_;
  std::vector<WorkingPose> fits_;
  std::vector<PoseSupport> support_;
};

}  // namespace consimd::detail
