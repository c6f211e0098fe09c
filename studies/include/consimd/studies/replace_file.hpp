// Output files appear whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Writes `content` to a file of another name in the same folder and renames it to `path`, following symbolic links.
/// What is not a regular file (a pipe, /dev/null) is written to directly. Throws std::runtime_error that names the
/// file.
void replace_file(const std::filesystem::path& path, std::string_view content);

/// Throws std::runtime_error unless `path` can be written by `replace_file`; leaves nothing behind.
void require_replaceable(const std::filesystem::path& path);

/// Makes the folder and its parents where missing. Throws std::runtime_error if that fails or files cannot be made in
/// it.
void require_writable_folder(const std::filesystem::path& folder);

}  // namespace studies
}  // namespace consimd
