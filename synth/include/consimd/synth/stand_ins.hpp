// Stand-ins for the scan pairs that the TCF paper is evaluated on: synthetic problems with the numbers of its table of
// data sets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include <consimd/kernels/export.hpp>
#include <consimd/synth/problem.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

/// What a stand-in's scanners see.
enum class ScannedScene : std::uint8_t { arch, courtyard, facade, office, trees, highway, country, urban, mixed };

/// A sequence of the paper (table "Dataset details") and how its scans are imitated. Lengths in metres. A pair's
/// numbers scatter about the given ones, which are averages over a sequence: its distance by up to a fifth, its
/// correspondences by 30 %, its inlier ratio by 60 %, each uniformly.
struct StandIn {
  std::string_view name;      ///< "arch", ..., "kitti09"
  std::string_view dataset;   ///< "ETH" or "KITTI"
  std::string_view sequence;  ///< as the paper has it: "Arch", "01"
  ScannedScene scene;
  double pair_distance;         ///< between the scanners
  std::size_t correspondences;  ///< |C|
  double inlier_ratio;
  double inlier_distance;  ///< largest residual of a valid correspondence, the paper's
  double noise_bound;      ///< what a solver is given
};

/// The five ETH and the five KITTI sequences of the paper, in its order.
[[nodiscard]] std::span<const StandIn> stand_ins() noexcept;

/// The stand-in of that name; throws std::invalid_argument on an unknown one, listing the known ones.
[[nodiscard]] const StandIn& stand_in(std::string_view name);

/// A pair of scans of a scene of that kind. Keypoints lie on walls, ground, poles, trunks, foliage and furniture and
/// are described by what surface they are on and where on it, up to its repetition: the corners of all windows look
/// alike, each with a little of its own. Rows are the pairs of keypoints that are among each other's three most similar
/// ones; so both clouds have points in up to three rows, and wrong pairs join places that look alike. A keypoint that
/// both scans see is found again some way along its surface, so that residuals have a broad distribution with near
/// misses, as those of real pairs do. Rows are inliers by the paper's rule, a residual of at most inlier_distance under
/// the true pose; Problem::sigma is their residuals' root mean square per axis.
///
/// The pair depends on (stand_in.name, seed, trial) alone. Not real data: the paper's numbers cannot be had from it.
[[nodiscard]] Problem stand_in_problem(const StandIn& stand_in, std::uint64_t seed, std::uint64_t trial);

}  // namespace synth
}  // namespace consimd
