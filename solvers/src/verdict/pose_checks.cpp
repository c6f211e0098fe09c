#include "verdict/pose_checks.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>

#include <consimd/kernels/length_consistency.hpp>
#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "bits/bit_rows.hpp"
#include "support/pose_candidate.hpp"
#include "support/row_blocks.hpp"
#include "support/source_scatter.hpp"

namespace consimd::detail {
namespace {

// Coordinates in the working frame are rounded to about this.
constexpr double kResolution = 1e-7;
// A length beyond every distance in the working frame.
constexpr double kEverything = 8.0;
// A reflection explains thin scenes nearly as well as the pose does; this many times its supporters tell.
constexpr double kMirrorSupportRatio = 1.1;
// Rows of a set that agree in length with one another and in place under a reflection: by chance hardly so many.
constexpr std::size_t kLeastImage = 8;

// With the moments of the supporters and the deviation of a residual in the working frame.
double rotation_deviation(const RigidMoments& moments, double working_sigma) {
  const Eigen::Vector3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(central_source_scatter(moments)).eigenvalues();
  return working_sigma / std::sqrt(std::max(axes[0] + axes[1], 0.0));
}

}  // namespace

double rotation_deviation(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double sigma) {
  return rotation_deviation(row_blocks::robust_moments(view, pose, {.scale = noise_bound, .cutoff = noise_bound}),
                            std::max(sigma * view.scale(), kResolution));
}

bool coincident_or_collinear(const Correspondences& correspondences) {
  // In double precision: sums of the kernels, in single, would give a line some width.
  const CorrespondenceView view = correspondences.view();
  double count = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < view.size(); ++k) {
    const Eigen::Vector3d point(view.source(0)[k], view.source(1)[k], view.source(2)[k]);
    if (!point.allFinite()) continue;
    count += 1.0;
    sum += point;
    squares += point * point.transpose();
  }
  if (count < 3.0) return true;
  const Eigen::Vector3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(squares - sum * sum.transpose() / count).eigenvalues();
  // What rounding adds across the line, two axes of it, is no information.
  const double across = axes[0] + axes[1] - 2.0 * count * kResolution * kResolution;
  return kResolution > kLargestRotationDeviation * std::sqrt(std::max(across, 0.0));
}

std::vector<std::uint32_t> rows_agreeing_with(const Correspondences& correspondences, const IndexTriple& triple,
                                              double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  const std::size_t words = view.words();
  std::vector<std::uint64_t> bits(3 * words);
  std::array<std::uint32_t, 3> counts{};
  length_consistency_bits(view, std::array{triple.first, triple.second, triple.third}, 2.0 * noise_bound, bits, counts);
  for (std::size_t w = 0; w < words; ++w) bits[w] &= bits[words + w] & bits[2 * words + w];
  std::vector<std::uint32_t> rows;
  members_of(std::span(bits).first(words), rows);
  return rows;
}

std::size_t mirrored_supporters(const Correspondences& correspondences, const std::vector<std::uint32_t>& set,
                                double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  std::vector<float> source;
  std::vector<float> target;
  for (const std::uint32_t row : set) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      source.push_back((axis == 0 ? -1.0F : 1.0F) * view.source(axis)[row]);
      target.push_back(view.target(axis)[row]);
    }
  }
  const Correspondences mirrored(PointSpan<float>::interleaved(source.data(), set.size()),
                                 PointSpan<float>::interleaved(target.data(), set.size()));
  const double bound = noise_bound * view.scale();  // the caller's unit is the working frame's here
  WorkingPose pose = to_working_pose(RigidTransform::Identity());
  for (const double cutoff : {kEverything, 4.0 * bound, 2.0 * bound, bound}) {
    const RigidFit fit = rigid_fit(robust_moments(mirrored.view(), pose, {.scale = cutoff, .cutoff = cutoff}));
    if (!fit.determined()) return 0;
    pose = to_working_pose(fit.pose);
  }
  return pose_inliers(mirrored.view(), pose, bound).size();
}

bool is_mirrored(std::size_t mirrored_supporters, std::size_t supporters) {
  return static_cast<double>(mirrored_supporters) > kMirrorSupportRatio * static_cast<double>(supporters);
}

bool is_mirror_image(std::size_t mirrored_supporters, std::size_t set_size) {
  return mirrored_supporters >= kLeastImage && 2 * mirrored_supporters > set_size;
}

}  // namespace consimd::detail
