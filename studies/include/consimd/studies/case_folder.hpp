// Registration problems with their truth and limits of success in folders.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/case_group.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// What a case.json holds.
struct CaseFile {
  double noise_bound = 0.0;  ///< largest residual of an inlier, the unit of the correspondences, > 0
  // Limits of a success, > 0; none where there is no such number.
  std::optional<double> max_rotation_error_deg = {};
  std::optional<double> max_translation_error = {};  ///< "max_translation_error_m" in the file
  // Where the case is from; empty where the file does not say.
  std::string dataset = {};
  std::string sequence = {};

  /// Throws std::runtime_error that names `path`, the file, and the limit that is missing.
  [[nodiscard]] PoseLimits limits(const std::filesystem::path& path) const;
};

/// Throws std::runtime_error that names the file if it is no JSON object, its noise bound is no number above 0, or data
/// set or sequence are no texts.
[[nodiscard]] CaseFile read_case_file(const std::filesystem::path& path);

/// The cases in `folder`: every sub-folder with a correspondences.txt (N x 6), a pose.txt (4 x 4 or 3 x 4, source to
/// target) and a case.json,
/// see `CaseFile`. Limits are not needed with a `preset` that sets them (see success_limits.hpp); cases of one data set
/// and sequence are one group. Rows within the noise bound of the true pose count as inliers. Groups and cases come in
/// alphabetical order; cases are read when they are run, and it is an error if they have changed by then. Throws
/// std::runtime_error that names the file, on a folder without cases too.
[[nodiscard]] std::vector<CaseGroup> case_folder_groups(const std::filesystem::path& folder, std::uint64_t seed,
                                                        std::string_view preset);

}  // namespace studies
}  // namespace consimd
