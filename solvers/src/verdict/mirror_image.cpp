#include "verdict/mirror_image.hpp"

#include <algorithm>
#include <vector>

#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "bits/bit_rows.hpp"
#include "support/row_blocks.hpp"

namespace consimd::detail {
namespace {

// A reflection explains thin scenes nearly as well as the pose does; this many times its supporters tell.
constexpr double kMirrorSupportRatio = 1.1;
// Rows of a set that agree in length with one another and in place under a reflection: by chance hardly so many. Where
// there are no others to choose from four do, the fewest that are not their own mirror image.
constexpr std::size_t kLeastImage = 8;
constexpr std::size_t kLeastOfAll = 4;
// Rows outside of the set that a reflection of half a dozen supporters brings in by chance.
constexpr std::size_t kByChance = 2;

// The rotation of the mirrored sources as a reflection of the sources themselves.
WorkingPose reflection(const RigidFit& of_mirrored) {
  WorkingPose pose = to_working_pose(of_mirrored.pose);
  for (std::size_t row = 0; row < 3; ++row) pose.rotation[3 * row] = -pose.rotation[3 * row];
  return pose;
}

}  // namespace

RigidMoments mirrored(const RigidMoments& moments) {
  RigidMoments result = moments;
  result.source[0] = -result.source[0];
  for (std::size_t row = 0; row < 3; ++row) result.cross[3 * row] = -result.cross[3 * row];
  for (const std::size_t product : {1U, 2U}) result.source_scatter[product] = -result.source_scatter[product];
  return result;
}

MirroredSupport mirrored_support(const Correspondences& correspondences, std::span<const std::uint32_t> set,
                                 double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  std::vector<std::uint64_t> rows(view.words());
  for (const std::uint32_t row : set) set_bit(rows, row);
  RigidFit fit = rigid_fit(mirrored(subset_moments(view, rows)));
  for (const double cutoff : {4.0 * noise_bound, 2.0 * noise_bound, noise_bound}) {
    if (!fit.determined()) return {};
    const RobustWeight within{.scale = cutoff, .cutoff = cutoff};
    fit = rigid_fit(mirrored(row_blocks::robust_moments(view, reflection(fit), within)));
  }
  if (!fit.determined()) return {};
  std::vector<std::uint64_t> aligned(view.words());
  const std::size_t of_all = row_blocks::alignment_bits(view, reflection(fit), noise_bound, aligned);
  intersect(rows, aligned, rows);
  return {popcount(rows), of_all};
}

bool is_mirrored(const MirroredSupport& image, std::size_t supporters) {
  const auto is_more = [supporters](std::size_t of_image) {
    return static_cast<double>(of_image) > kMirrorSupportRatio * static_cast<double>(supporters);
  };
  return is_more(image.of_set) || (is_more(image.of_all) && image.of_all > supporters + kByChance);
}

bool is_mirror_image(const MirroredSupport& image, std::size_t set_size, std::size_t rows) {
  const std::size_t least = std::clamp(rows, kLeastOfAll, kLeastImage);
  return image.of_set >= least && 2 * image.of_set > set_size;
}

bool is_part_of_a_mirror_image(const Correspondences& correspondences, std::span<const std::uint32_t> supporters,
                               double noise_bound) {
  return is_mirrored(mirrored_support(correspondences, supporters, noise_bound), supporters.size());
}

}  // namespace consimd::detail
