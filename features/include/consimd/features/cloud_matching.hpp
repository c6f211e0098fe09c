// From two clouds to correspondences in one call.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <consimd/features/cell_grid.hpp>
#include <consimd/features/matching.hpp>
#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

struct CloudMatchingOptions {
  /// Side of the voxels that both clouds are thinned out with, caller's unit. Chosen when not given: see
  /// `choose_voxel`.
  std::optional<double> voxel = std::nullopt;
  /// Radius of normals, in voxels; > 0, at most descriptor_radius.
  double normal_radius = 2.0;
  /// Radius of descriptors, in voxels; > 0.
  double descriptor_radius = 5.0;
  /// Points of each cloud, drawn at random, that are described and matched; all where not given.
  std::optional<std::size_t> keypoints = 5000;
  /// Choose them as far from each other as can be instead (see point_subset.hpp).
  bool farthest = false;
  /// Draw only from the ISS keypoints (see iss.hpp).
  bool iss = false;
  /// Radii of these: of the neighbourhood and of the suppression, in voxels; > 0, at most descriptor_radius.
  double iss_radius = 3.0;
  double iss_suppression_radius = 2.0;
  MatchOptions matches = {};
  /// Which points are drawn depends on it and on nothing else.
  std::uint64_t seed = 1;
  /// Where the scans were taken from, each in its cloud's frame: normals are turned there (see normals.hpp), and the
  /// source's goes to the correspondences.
  std::optional<std::array<double, 3>> source_viewpoint = std::array<double, 3>{0.0, 0.0, 0.0};
  std::optional<std::array<double, 3>> target_viewpoint = std::array<double, 3>{0.0, 0.0, 0.0};
};

/// What became of one cloud.
struct CloudSummary {
  std::size_t points = 0;
  std::size_t left_out = 0;  ///< rows without a place, beside the points
  std::size_t voxels = 0;
  std::size_t descriptors = 0;
  double resolution = 0.0;  ///< of the voxels, see cell_grid.hpp; caller's unit
};

struct CloudMatches {
  /// The matched points, caller's frames, by source point. `rows` of the matches count the descriptors.
  Correspondences correspondences;
  std::vector<std::array<double, 3>> source_points;
  std::vector<std::array<double, 3>> target_points;
  std::vector<Match> matches;
  CloudSummary source;
  CloudSummary target;
  /// The voxels of both with their normals: what a pose is refined on.
  std::shared_ptr<const CellGrid> source_voxels;
  std::shared_ptr<const CellGrid> target_voxels;
  double voxel = 0.0;  ///< used
  /// The noise bound to register with, tau: three times the mean of the two resolutions; of the voxel, where these are
  /// not finite or 0.
  double noise_bound = 0.0;
  std::vector<StageReport> stages;  ///< inputs and outputs: both clouds together
  /// A sentence on what looks like a mistake, such as different units; empty as a rule.
  std::string hint;
};

/// A voxel with which the cloud has about 12 000 of them, or three quarters of its points if that is less, to two
/// digits; caller's unit. 1 for a cloud without extent. Throws std::invalid_argument on an empty cloud.
[[nodiscard]] double choose_voxel(const Cloud& cloud);

/// Voxel grid, normals, random points, FPFH, matches: the front end of the TCF paper. Without a voxel the larger of
/// those chosen for the two clouds is used. In parallel; the same for any number of threads and instruction set. Throws
/// std::invalid_argument on an empty cloud, on bad options, or on a voxel that is larger than both clouds or less than
/// a 2^20th of one.
[[nodiscard]] CloudMatches match_clouds(const Cloud& source, const Cloud& target,
                                        const CloudMatchingOptions& options = {});

}  // namespace features
}  // namespace consimd
