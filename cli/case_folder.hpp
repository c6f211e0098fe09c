// Registration problems with their truth in folders.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include <consimd/studies/case_group.hpp>

namespace consimd::cli {

/// The cases in `folder`: every sub-folder with a correspondences.txt (N x 6), a pose.txt (4 x 4 or 3 x 4, source to
/// target) and a case.json:
///   noise_bound                                        largest residual of an inlier, the file's unit, > 0
///   max_rotation_error_deg, max_translation_error_m    limits of a success; not needed with a preset that sets them
///   dataset, sequence                                  optional: cases of one data set and sequence are one group
/// Rows within the noise bound of the true pose count as inliers. Groups and cases come in alphabetical order; cases
/// are read when they are run. Throws std::runtime_error that names the file, on a folder without cases too.
[[nodiscard]] std::vector<studies::CaseGroup> case_folder_groups(const std::filesystem::path& folder,
                                                                 std::uint64_t seed, std::string_view preset);

}  // namespace consimd::cli
