// Pairs of scans as the cases of a comparison.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <consimd/features/cloud_matching.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/studies/case_group.hpp>
#include <consimd/studies/scan_layout.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

struct ScanOptions {
  LayoutOptions layout;
  /// How correspondences are made; its seed is that of the layout. See `layout_front_end`.
  features::CloudMatchingOptions front_end = {};
  std::optional<double> missing = {};      ///< coordinates of a point that is none, see Cloud
  std::optional<double> noise_bound = {};  ///< of all pairs; of each pair by its resolution when not given
  /// Correspondences that have been made are kept in this folder, a sub-folder a pair, as `case_folder_groups` reads
  /// it; empty: they are made anew in each call.
  std::filesystem::path cache = {};
};

/// All that decides what the cases are, beside the files: names and values.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> scan_option_texts(const ScanOptions& options);

struct ScanGroups {
  std::vector<CaseGroup> groups;
  std::vector<std::string> notes;  ///< those of the list
};

/// A group for every sequence, a case for every pair, with the limits of `preset`, "case" meaning what the users of the
/// data set take (see ScanPair). Every scan is read once, in parallel in the caller's arena, so that one that is
/// missing or damaged is an error before anything runs: whole, unless there are correspondences of it. A case's digest
/// is that of both files, the pose and the options of the front end; correspondences of another digest are made anew.
///
/// `on_scan`: called with the number of scans read and of all, one call at a time, from any thread; what it throws
/// ends the call.
///
/// Throws what `read_scan_list` and `features::read_cloud` throw, and std::invalid_argument on a bad option or preset.
[[nodiscard]] ScanGroups scan_groups(const ScanOptions& options, std::string_view preset,
                                     const std::function<void(std::size_t, std::size_t)>& on_scan = {});

}  // namespace studies
}  // namespace consimd
