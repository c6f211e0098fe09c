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
// Rows that a turn would bring into place by chance, as many as a success may have false poses: from there on one that
// it does bring tells nothing.
constexpr double kChosenByChance = 1e-3;

Eigen::Vector3d eigenvalues(const Eigen::Matrix3d& scatter) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter, Eigen::EigenvaluesOnly).eigenvalues();
}

double working_sigma(const CorrespondenceView& view, double sigma) {
  return std::max(sigma * view.scale(), kResolution);
}

Eigen::Vector3d source_vector(const CorrespondenceView& view, std::size_t k) {
  return {view.source(0)[k], view.source(1)[k], view.source(2)[k]};
}

// Number, centroid and scatter about it of points that are added.
struct Scatter {
  double count = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();

  void add(const Eigen::Vector3d& point, double times = 1.0) {
    count += times;
    sum += times * point;
    squares += times * point * point.transpose();
  }
  [[nodiscard]] Eigen::Vector3d centroid() const { return sum / count; }
  [[nodiscard]] Eigen::Matrix3d about_centroid() const { return squares - sum * sum.transpose() / count; }
};

Scatter scatter_of(const CorrespondenceView& view, const std::vector<std::uint32_t>& rows) {
  Scatter scatter;
  for (const std::uint32_t row : rows) scatter.add(source_vector(view, row));
  return scatter;
}

// What so many points on a line scatter across it, along both axes together, if all the noise of their residuals is
// theirs: its mean and three deviations of a sum of squares.
double scatter_of_noise(double count, double working_sigma) {
  return 2.0 * working_sigma * working_sigma * (count + 3.0 * std::sqrt(count));
}

// Scatter across their longest axis from which on points determine a rotation.
double least_scatter(double count, double working_sigma) {
  const double turned = working_sigma / kLargestRotationDeviation;
  return scatter_of_noise(count, working_sigma) + turned * turned;
}

double across_longest_axis(const Eigen::Vector3d& axes) { return axes[0] + axes[1]; }

}  // namespace

double rotation_deviation(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double sigma) {
  const RigidMoments moments = row_blocks::robust_moments(view, pose, {.scale = noise_bound, .cutoff = noise_bound});
  const double across = across_longest_axis(eigenvalues(central_source_scatter(moments)));
  return working_sigma(view, sigma) / std::sqrt(std::max(across, 0.0));
}

bool leaves_a_rotation_free(const CorrespondenceView& view, const std::vector<std::uint32_t>& supporters,
                            double noise_bound, double sigma) {
  const Scatter scatter = scatter_of(view, supporters);
  const double least = least_scatter(scatter.count, working_sigma(view, sigma));
  const Eigen::Vector3d axes = eigenvalues(scatter.about_centroid());
  if (across_longest_axis(axes) <= least) return true;
  // Where all but one are on a line, all are near a plane, and what is off the line in it is that one.
  if (axes[0] > least) return false;
  const Eigen::Vector3d centroid = scatter.centroid();
  double furthest = 0.0;
  for (const std::uint32_t row : supporters) {
    furthest = std::max(furthest, (source_vector(view, row) - centroid).squaredNorm());
  }
  if (across_longest_axis(axes) > least + 2.0 * furthest) return false;
  const auto others = [&](std::uint32_t row) {
    Scatter of_others = scatter;
    of_others.add(source_vector(view, row), -1.0);
    return of_others;
  };
  const auto left = [&](std::uint32_t row) { return across_longest_axis(eigenvalues(others(row).about_centroid())); };
  const std::uint32_t pivot = *std::ranges::min_element(supporters, {}, left);
  if (left(pivot) > least) return false;
  // The chance that a row is as far along the line, and from it, in both clouds is that of two lengths to agree: the
  // rows spread over some square root of twelve deviations.
  const Scatter on_line = others(pivot);
  const Eigen::Vector3d line =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(on_line.about_centroid()).eigenvectors().col(2);
  Scatter all;
  for (std::size_t k = 0; k < view.size(); ++k) all.add(source_vector(view, k) - on_line.centroid());
  const double squared_along = line.dot(all.squares * line) / all.count;
  const double squared_off = all.squares.trace() / all.count - squared_along;
  const double bound = noise_bound * view.scale();
  const auto agree = [&](double square) { return std::min(2.0 * bound / std::sqrt(12.0 * square), 1.0); };
  return all.count * agree(squared_along) * agree(squared_off) > kChosenByChance;
}

bool coincident_or_collinear(const Correspondences& correspondences) {
  // In double precision: sums of the kernels, in single, would give a line some width.
  const CorrespondenceView view = correspondences.view();
  Scatter scatter;
  for (std::size_t k = 0; k < view.size(); ++k) {
    if (const Eigen::Vector3d point = source_vector(view, k); point.allFinite()) scatter.add(point);
  }
  if (scatter.count < 3.0) return true;
  // What rounding adds across the line, two axes of it, is no information.
  const double across =
      across_longest_axis(eigenvalues(scatter.about_centroid())) - 2.0 * scatter.count * kResolution * kResolution;
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

}  // namespace consimd::detail
