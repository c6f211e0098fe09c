// The readers of the layouts, and what they share.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/studies/scan_layout.hpp>

namespace consimd::studies::detail {

[[nodiscard]] ScanList read_kitti(const LayoutOptions& options);
[[nodiscard]] ScanList read_eth(const LayoutOptions& options);
[[nodiscard]] ScanList read_3dmatch(const LayoutOptions& options, bool with_information);
[[nodiscard]] ScanList read_pair_table(const LayoutOptions& options);

/// A folder's own name, however its path ends.
[[nodiscard]] std::string name_of(const std::filesystem::path& folder);

/// The sub-folders, in the order of their names. Throws std::runtime_error that names the folder.
[[nodiscard]] std::vector<std::filesystem::path> folders_in(const std::filesystem::path& folder);

/// The files, likewise.
[[nodiscard]] std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);

/// folder/STEM.EXT for the first ending of a cloud that is there; none without.
[[nodiscard]] std::optional<std::filesystem::path> cloud_file(const std::filesystem::path& folder,
                                                              std::string_view stem);

/// Whether the file's ending is one of a cloud.
[[nodiscard]] bool is_cloud_file(const std::filesystem::path& path);

/// Whether the options take that sequence.
[[nodiscard]] bool wanted(const LayoutOptions& options, std::string_view sequence);

/// Throws std::runtime_error "FILE: is missing" unless it is a file.
void require_file(const std::filesystem::path& path);

/// `rows` of them at random where there are more, in their order.
void keep_some(std::vector<ScanPair>& pairs, const LayoutOptions& options);

}  // namespace consimd::studies::detail
