// Correspondences from files that hold them as points of two clouds.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include <consimd/features/cloud_files.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// Row k of `source` may be the same point as row k of `target`; file's unit and frames.
struct MatchedPoints {
  std::vector<std::array<double, 3>> source;
  std::vector<std::array<double, 3>> target;

  /// Throws std::invalid_argument that names a row whose coordinates are not finite.
  [[nodiscard]] Correspondences correspondences() const;
};

/// Reads matches as learned matchers write them: an .npz, stored or deflated, with src_corr_points and ref_corr_points,
/// N x 3 each; other arrays, such as corr_scores, are passed over. Or an .npy of N x 6: source x y z and target x y z.
/// Throws std::runtime_error "FILE: what".
[[nodiscard]] MatchedPoints read_array_matches(const std::filesystem::path& path);

/// The columns of the source, then those of the target.
using PairColumns = std::array<TextColumns, 2>;

/// Reads two clouds in any of the forms of `read_cloud` whose rows belong together. columns: of text, as there. Throws
/// std::runtime_error that names a file, also where they have different numbers of rows.
[[nodiscard]] MatchedPoints read_matched_rows(const std::filesystem::path& source, const std::filesystem::path& target,
                                              const std::optional<PairColumns>& columns = std::nullopt);

/// Reads two clouds and text with a line for each match: a row of the source and one of the target, counted from 0,
/// and what else. columns: of the clouds, as above. Throws std::runtime_error that names a file, and its line where a
/// row is not there.
[[nodiscard]] MatchedPoints read_indexed_matches(const std::filesystem::path& source,
                                                 const std::filesystem::path& target,
                                                 const std::filesystem::path& pairs,
                                                 const std::optional<PairColumns>& columns = std::nullopt);

}  // namespace features
}  // namespace consimd
