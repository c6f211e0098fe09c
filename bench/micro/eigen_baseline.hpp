// The kernels as a researcher writes them with Eigen: points as vectors in double, the paper's equations term by term,
// one hypothesis at a time. A baseline for speed, and an independent check of the kernels' results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#define CONSIMD_BASELINE __attribute__((visibility("default")))

namespace consimd::bench {

struct EigenCloud {
  std::vector<Eigen::Vector3d> source;
  std::vector<Eigen::Vector3d> target;
};

struct EigenPose {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
};

/// The sums that a weighted Kabsch fit takes.
struct EigenMoments {
  double weight = 0.0;
  Eigen::Vector3d source = Eigen::Vector3d::Zero();
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  ///< sum w q p^T
};

namespace eigen {

// Consensus sets: the rows that pass.
CONSIMD_BASELINE std::uint32_t length_count(const EigenCloud& cloud, std::uint32_t seed, double bound);
CONSIMD_BASELINE std::uint32_t angle_count(const EigenCloud& cloud, std::uint32_t first, std::uint32_t second,
                                           double bound);
CONSIMD_BASELINE std::uint32_t alignment_count(const EigenCloud& cloud, const EigenPose& pose, double bound);
CONSIMD_BASELINE void length_set(const EigenCloud& cloud, std::uint32_t seed, double bound,
                                 std::vector<std::uint32_t>* set);
CONSIMD_BASELINE void angle_set(const EigenCloud& cloud, std::uint32_t first, std::uint32_t second, double bound,
                                std::vector<std::uint32_t>* set);
CONSIMD_BASELINE void alignment_set(const EigenCloud& cloud, const EigenPose& pose, double bound,
                                    std::vector<std::uint32_t>* set);
/// sum(1 - r^2 / bound^2) over r < bound.
CONSIMD_BASELINE double alignment_score(const EigenCloud& cloud, const EigenPose& pose, double bound);

CONSIMD_BASELINE EigenMoments weighted_moments(const EigenCloud& cloud, const float* weights);
CONSIMD_BASELINE EigenMoments subset_moments(const EigenCloud& cloud, const std::vector<std::uint32_t>& rows);
/// Weights 1 / (1 + r^2 / scale^2) where r < cutoff.
CONSIMD_BASELINE EigenMoments cauchy_moments(const EigenCloud& cloud, const EigenPose& pose, double scale,
                                             double cutoff);

/// Kabsch's fit with Eigen's SVD.
CONSIMD_BASELINE EigenPose three_point_fit(const EigenCloud& cloud, const std::uint32_t (&rows)[3]);

// Matrices of bool cross this interface as the bytes of their columns: how Eigen allocates depends on the flags of each
// source.

/// matrix: N x N, symmetric; entry (i, j) tells whether i and j are length consistent.
CONSIMD_BASELINE void consistency_matrix(const EigenCloud& cloud, double bound, std::vector<char>* matrix);
/// Number of entries set in both.
CONSIMD_BASELINE std::uint32_t common_count(const char* a, const char* b, std::size_t size);

}  // namespace eigen
}  // namespace consimd::bench
