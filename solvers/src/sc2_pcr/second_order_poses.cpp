// The consensus sets of SC2-PCR and their poses.
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/sc2_pcr.hpp>

#include "bits/bit_rows.hpp"
#include "support/points.hpp"

namespace consimd {
namespace {

constexpr std::size_t kSeedsPerTask = 8;
constexpr std::size_t kLargestSet = 64;  // consistency within a set is one word a member
constexpr double kSmallestChange = 1e-5;

WorkingPose no_pose() {
  WorkingPose pose;
  std::ranges::fill(pose.rotation, std::numeric_limits<float>::quiet_NaN());
  std::ranges::fill(pose.translation, std::numeric_limits<float>::quiet_NaN());
  return pose;
}

/// The set of one seed after the other; holds the memory that takes.
class SeedSet {
 public:
  SeedSet(const CorrespondenceView& view, const CompatibilityMatrices& matrices, const Sc2PcrOptions& options)
      : view_(view),
        matrices_(matrices),
        options_(options),
        bound_(options.length_tolerance * options.noise_bound * view.scale()) {}

  void find(std::uint32_t seed) {
    collect_most_common_neighbours(seed);
    keep_most_compatible();
  }

  /// The seed first, then by falling agreement.
  [[nodiscard]] std::span<const std::uint32_t> members() const { return {members_.data(), size_}; }

  WorkingPose fit() {
    if (size_ < 3) return no_pose();
    weigh();
    RigidMoments moments{};
    for (std::size_t m = 0; m < size_; ++m) add(members_[m], weights_[m], moments);
    const RigidFit fit = rigid_fit(moments);
    return fit.determined() ? to_working_pose(fit.pose) : no_pose();
  }

 private:
  // Higher with merit, of equal merit with lower rows.
  static std::uint64_t rank(std::uint32_t merit, std::uint32_t row) {
    return std::uint64_t{merit} << 32 | (0xffffffff - row);
  }
  static std::uint32_t row_of(std::uint64_t rank) { return 0xffffffff - static_cast<std::uint32_t>(rank); }

  /// Keeps the `count` highest ranks, highest first, as members behind the first.
  void take_highest(std::size_t count) {
    const auto end = ranks_.begin() + static_cast<std::ptrdiff_t>(std::min(count, ranks_.size()));
    std::nth_element(ranks_.begin(), end, ranks_.end(), std::ranges::greater{});
    std::sort(ranks_.begin(), end, std::ranges::greater{});
    size_ = 1;
    for (auto rank = ranks_.begin(); rank != end; ++rank) members_[size_++] = row_of(*rank);
  }

  void collect_most_common_neighbours(std::uint32_t seed) {
    detail::members_of(matrices_.loose.row(seed), neighbours_);
    counts_.resize(neighbours_.size());
    and_popcount_rows(matrices_.tight, matrices_.tight.row(seed), neighbours_, counts_);
    ranks_.clear();
    for (std::size_t k = 0; k < neighbours_.size(); ++k) {
      if (neighbours_[k] != seed && counts_[k] > 0) ranks_.push_back(rank(counts_[k], neighbours_[k]));
    }
    members_[0] = seed;
    take_highest(options_.first_set - 1);
  }

  // All members are compatible with the seed, so that their neighbours within the set are those they share with it.
  void keep_most_compatible() {
    ranks_.clear();
    for (std::size_t m = 1; m < size_; ++m) {
      const std::span<const std::uint64_t> row = matrices_.loose.row(members_[m]);
      std::uint32_t compatible = 0;
      for (std::size_t other = 0; other < size_; ++other) {
        compatible += static_cast<std::uint32_t>(row[members_[other] / kBlock] >> (members_[other] % kBlock) & 1);
      }
      ranks_.push_back(rank(compatible, members_[m]));
    }
    take_highest(options_.second_set - 1);
  }

  // Leading eigenvector of the soft first-order compatibilities within the set.
  void weigh() {
    for (std::size_t a = 0; a < size_; ++a) {
      soft_[a][a] = 0.0;
      for (std::size_t b = 0; b < a; ++b) {
        const double difference =
            detail::distance(detail::source_point(view_, members_[a]), detail::source_point(view_, members_[b])) -
            detail::distance(detail::target_point(view_, members_[a]), detail::target_point(view_, members_[b]));
        soft_[a][b] = soft_[b][a] = std::max(0.0, 1.0 - difference * difference / (bound_ * bound_));
      }
    }
    std::fill_n(weights_.begin(), size_, 1.0);
    for (std::uint32_t round = 0; round < options_.power_iterations; ++round) {
      std::array<double, kLargestSet> next;
      double squares = 0.0;
      for (std::size_t a = 0; a < size_; ++a) {
        next[a] = 0.0;
        for (std::size_t b = 0; b < size_; ++b) next[a] += soft_[a][b] * weights_[b];
        squares += next[a] * next[a];
      }
      if (!(squares > 0.0)) return;
      const double length = std::sqrt(squares);
      bool converged = true;
      for (std::size_t a = 0; a < size_; ++a) {
        next[a] /= length;
        if (std::abs(next[a] - weights_[a]) > kSmallestChange * weights_[a]) converged = false;
        weights_[a] = next[a];
      }
      if (converged) return;
    }
  }

  void add(std::uint32_t row, double weight, RigidMoments& moments) const {
    moments.weight += weight;
    for (std::size_t a = 0; a < 3; ++a) {
      const double q = static_cast<double>(view_.target(a)[row]);
      moments.source[a] += weight * static_cast<double>(view_.source(a)[row]);
      moments.target[a] += weight * q;
      for (std::size_t b = 0; b < 3; ++b) {
        moments.cross[3 * a + b] += weight * q * static_cast<double>(view_.source(b)[row]);
      }
    }
  }

  CorrespondenceView view_;
  const CompatibilityMatrices& matrices_;
  const Sc2PcrOptions& options_;
  double bound_;  // d, working frame
  std::vector<std::uint32_t> neighbours_;
  std::vector<std::uint32_t> counts_;
  std::vector<std::uint64_t> ranks_;
  std::array<std::uint32_t, kLargestSet> members_{};
  std::size_t size_ = 0;
  std::array<double, kLargestSet> weights_{};
  std::array<std::array<double, kLargestSet>, kLargestSet> soft_{};
};

}  // namespace

void CompatibilityMatrices::compute(const CorrespondenceView& view, double d) {
  loose.compute(view, d);
  tight.compute(view, d / 2.0);
}

SeedPoses second_order_poses(const Correspondences& correspondences, const CompatibilityMatrices& matrices,
                             std::span<const std::uint32_t> seeds, const Sc2PcrOptions& options) {
  SeedPoses result{std::vector<WorkingPose>(seeds.size(), no_pose()), std::vector<IndexTriple>(seeds.size())};
  std::atomic<bool> stopped = false;
  tbb::enumerable_thread_specific<SeedSet> sets(correspondences.view(), matrices, options);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, seeds.size(), kSeedsPerTask), [&](const auto& range) {
    if (options.stop.met()) {
      stopped = true;
      return;
    }
    SeedSet& set = sets.local();
    for (std::size_t s = range.begin(); s < range.end(); ++s) {
      set.find(seeds[s]);
      const std::span<const std::uint32_t> members = set.members();
      result.poses[s] = set.fit();
      result.leading[s] = members.size() < 3 ? IndexTriple{seeds[s], seeds[s], seeds[s]}
                                             : IndexTriple{members[0], members[1], members[2]};
    }
  });
  result.stopped = stopped;
  return result;
}

}  // namespace consimd
