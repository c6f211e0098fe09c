// Clouds from files and into files.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// Which words of a line of text are x, y and z, counted from 1.
using TextColumns = std::array<std::size_t, 3>;

/// Reads the points of a cloud; what else a file holds of them is passed over. Which form it is tells its beginning, or
/// its ending:
///   PLY      ascii, binary of both byte orders
///   PCD      ascii, binary, binary_compressed
///   NPY      N x 3 or more columns of float32 or float64, C or Fortran order, of both byte orders; up to six rows of
///            more than nine numbers are taken for a transpose, an error
///   NPZ      the same, stored or deflated: the array points, xyz or pcd, or the only one
///   LAS      versions 1.0 to 1.4; not LAZ
///   .bin     KITTI's: float32 x, y, z, reflectance
///   text     a point a line: x y z and what else, separated by blanks, or by commas or semicolons where a line has
///   any;
///            '#' starts a comment, as do '//' and '%' at the beginning of a line; a first line of names, or a comment
///            with a name for each column, tells where x, y and z are; numbers of rows in the first column are passed
///            over, as is a first line with how many points follow, which has to be true
/// `missing`: see Cloud. `columns`: of text, whatever names it has; of a file of another form they are a fault. "-"
/// reads the standard input. Throws std::runtime_error "FILE: what" (of text "FILE:LINE: what") on a file that cannot
/// be read or is damaged: a header that promises more than there is reserves no memory. Throws std::invalid_argument on
/// a column of 0.
[[nodiscard]] Cloud read_cloud(const std::filesystem::path& path, std::optional<double> missing = std::nullopt,
                               const std::optional<TextColumns>& columns = std::nullopt);

/// The points of a cloud under a motion as a binary little-endian PLY file of doubles, a vertex for each row that was
/// given to the cloud's constructor, in their order: NaN where a row had no place.
[[nodiscard]] std::string moved_ply(const Cloud& cloud, const RigidTransform& motion);

}  // namespace features
}  // namespace consimd
