// Problems as text files: written for `consimd register` and any script, and read.
//
// A file of numbers has rows of them, separated by blanks or single commas or semicolons, whatever the locale. '#'
// starts a comment, as do '//' and '%' at the beginning of a line; empty lines, ends of lines of all systems (LF, CRLF,
// CR), double quotes around numbers and a UTF-8 byte-order mark are allowed. Anything else (text, NaN, infinity,
// decimal commas, UTF-16) is a std::runtime_error "FILE:LINE: what". The file "-" is the standard input.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/synth/problem.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

/// Writes four files to `folder`, which is made if need be:
///   correspondences.txt  N rows of source xyz and target xyz after a '#' line that names the columns
///   pose.txt             the true T_target_source, 4 x 4, its rotation multiplied by the scale: what maps the source
///   labels.txt           N rows, 1 for a true inlier, else 0
///   case.json            the noise bound, three sigma, and limits of success, as `consimd compare` reads them; not
///                        where sigma is 0
/// Numbers carry the digits (at most 17 significant ones) that read back as the same double.
/// Every file is written whole under a temporary name before the first is renamed, so a failure leaves nothing
/// half-written. Throws std::runtime_error naming the path, and std::invalid_argument if a number is not finite.
void write_problem(const Problem& problem, const std::filesystem::path& folder);

/// The lines of a file with `pose`, 4 x 4, its rotation multiplied by `scale`, as `write_problem` writes the true one.
[[nodiscard]] std::string pose_text(const RigidTransform& pose, double scale);

/// Writes `pose` with `scale` as `write_problem` writes the true one. Throws std::runtime_error naming the path.
void write_pose(const RigidTransform& pose, double scale, const std::filesystem::path& path);

/// Reads N >= 3 rows of source x y z and target x y z. Other columns must be told from these: by a first line of names,
/// of which six are those of x y z x y z (x1, source_x, sx), as an index that counts the rows before them, or by
/// `columns`, six numbers from 1. Throws std::runtime_error that names the file, and the line where there is one;
/// std::invalid_argument on bad `columns`.
[[nodiscard]] Correspondences read_correspondences(const std::filesystem::path& path,
                                                   std::span<const std::size_t> columns = {});

/// [R t] with the rotation nearest to `rotation`, which is one within 1e-3 an entry of R R^T, as numbers with few
/// digits are. Throws std::invalid_argument if it is not, or is a reflection.
[[nodiscard]] RigidTransform nearest_pose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation);

/// Reads one pose: a 4 x 4 or 3 x 4 matrix [R t], row by row or in one line of 16 or 12 numbers, as KITTI's; below a
/// line of three numbers, as in a gt.log of 3DMatch; or a line of TUM's form, time tx ty tz qx qy qz qw, the time left
/// out or not. A fourth row may be off 0 0 0 1 by rounding. The nearest pose is returned. Throws std::runtime_error
/// that names the file, also if R is no rotation, as above, or there are several poses.
[[nodiscard]] RigidTransform read_pose(const std::filesystem::path& path);

/// x_target = R (scale * x_source) + t.
struct ScaledPose {
  RigidTransform T_target_source = RigidTransform::Identity();
  double scale = 1.0;
};

/// Reads one pose in the same forms, whose matrix is [s R t], R a rotation as above, s > 0. Throws std::runtime_error
/// that names the file.
[[nodiscard]] ScaledPose read_scaled_pose(const std::filesystem::path& path);

/// A problem of real data: rows of `source` and `target`, N x 3 each, with the true pose. Rows within `noise_bound` of
/// it are the inliers.
[[nodiscard]] Problem labelled_problem(std::vector<double> source, std::vector<double> target,
                                       const RigidTransform& T_target_source, double noise_bound);

/// Reads a problem of real data: its correspondences, and the rigid true pose. Rows within `noise_bound` of that pose
/// are the inliers. Throws std::runtime_error that names the file.
[[nodiscard]] Problem read_problem(const std::filesystem::path& correspondences, const std::filesystem::path& pose,
                                   double noise_bound);

}  // namespace synth
}  // namespace consimd
