// Pairs of scans with their true poses, in the layouts in which data sets are published.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/features/cloud_matching.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/studies/success_limits.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// A layout, as `consimd compare --help` tells of it.
struct ScanLayout {
  std::string_view name;
  std::string_view description;
};

/// "kitti", "eth", "3dmatch", "pairs".
[[nodiscard]] std::span<const ScanLayout> scan_layouts() noexcept;

/// Which pairs of a data set are taken.
struct LayoutOptions {
  std::string folder;  ///< of the data set; of "pairs" also the CSV file itself
  std::string layout;  ///< a name of scan_layouts()
  /// Sequences of KITTI, scenes of ETH and 3DMatch, groups of "pairs"; empty: all.
  std::vector<std::string> sequences = {};
  /// Most pairs of each of them, drawn by the seed; not given: 200 of KITTI, the paper's number, and all of the others.
  std::optional<std::uint32_t> pairs = {};
  std::uint64_t seed = 1;
  // Of KITTI.
  double distance = 17.0;      ///< between the scans of a pair, metres; the paper's sequences have 16.95 to 17.02
  std::string pair_list = {};  ///< file with a pair a line: sequence, source frame, target frame; empty: drawn
  // Of 3DMatch.
  std::string ground_truth = {};  ///< folder with SCENE/gt.log; empty: within or beside the scenes' own folders
  /// Only pairs whose overlap in gt_overlap.log is above the first and at most the second; 3DLoMatch has 0.1 to 0.3.
  std::optional<std::array<double, 2>> overlap = {};
  bool skip_consecutive = false;  ///< leave out fragments that follow one another, as 3DMatch's own recall does
};

/// Two scans, each a file that `features::read_cloud` reads, whose pose is known.
struct ScanPair {
  std::string name;  ///< within its group, SOURCE-TARGET as a rule
  std::filesystem::path source;
  std::filesystem::path target;
  RigidTransform T_target_source = RigidTransform::Identity();
  /// What the data set's users call a success; none where there is no such custom.
  std::optional<PoseLimits> limits = {};
  /// Of 3DMatch: the 6 x 6 matrix in gt.info, row by row, of the overlap's displacements; none unless asked for.
  std::optional<std::array<double, 36>> information = {};
};

/// The pairs of one sequence or scene.
struct ScanGroup {
  std::string name;
  std::string dataset;   ///< "KITTI", "ETH", "3DMatch"; empty: none of these
  std::string sequence;  ///< of the data set
  std::string provenance;
  std::vector<ScanPair> pairs;
};

struct ScanList {
  std::vector<ScanGroup> groups;
  std::vector<std::string> notes;  ///< sentences on what was left out
};

/// Reads poses and lists of a data set; `with_information`: gt.info too. Groups and pairs come in the order of their
/// names and numbers, of a list in that of the list.
///
///   kitti    sequences/NN/velodyne/NNNNNN.bin, sequences/NN/calib.txt (its line "Tr:", scanner to camera) and
///            poses/NN.txt (12 numbers a frame, camera to world). A pair is a random frame and the later one whose
///            distance is nearest to `distance`, within a tenth of it; the later frame is the source. Frames without a
///            scan are not drawn. Sequences 11 to 21, which have no published poses, are left out unless named.
///   eth      SCENE/A.EXT or SCENE/A_*.EXT, and SCENE/A-B.pose, 4 x 4, A to B, for each pair: the form in which the
///            paper's authors give ETH's terrestrial scans
///   3dmatch  SCENE/cloud_bin_N.EXT (or Hokuyo_N, of ETH's laser scans in that form), and gt.log, fragment j to i, in
///            SCENE or SCENE-evaluation
///   pairs    pairs.csv: source, target, pose, and what else `consimd compare --help` names
///
/// Throws std::runtime_error that names what is missing or wrong: file, line, sequence; and std::invalid_argument on a
/// bad option, among them those of another layout.
[[nodiscard]] ScanList read_scan_list(const LayoutOptions& options, bool with_information = false);

/// How the users of the data set make its correspondences: KITTI with 0.3 m voxels and 5000 random points, ETH with
/// 0.1 m voxels and ISS keypoints (both the paper's), 3DMatch with 0.05 m voxels and 5000 random points; of "pairs"
/// the defaults of the front end. Throws std::invalid_argument on an unknown layout.
[[nodiscard]] features::CloudMatchingOptions layout_front_end(std::string_view layout);

}  // namespace studies
}  // namespace consimd
