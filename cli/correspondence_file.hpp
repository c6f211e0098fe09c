// Putative correspondences in a text file.
#pragma once

#include <filesystem>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::cli {

/// Reads N >= 3 rows of source x y z and target x y z (see `read_number_table` for the format). Throws
/// std::runtime_error that names the file, and the line where there is one.
[[nodiscard]] Correspondences read_correspondences(const std::filesystem::path& path);

}  // namespace consimd::cli
