// Putting a comparison together from its shards.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/comparison.hpp>
#include <consimd/studies/paper_tables.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// The folders of a comparison's shards among `folders` and directly in them, in the order of their names; none where
/// there are none.
[[nodiscard]] std::vector<std::filesystem::path> comparison_shards(const std::vector<std::filesystem::path>& folders);

struct MergedComparison {
  Comparison comparison;  ///< complete; its cases cannot be read
  TableOptions tables;
  std::string summary;  ///< text of comparison.json; where machines, builds or threads differ it lists all
};

/// Reads the shards in `folders`, in any order, and changes nothing in them; the data are not needed. Throws
/// std::runtime_error that names what is wrong: shards of different comparisons, divisions or versions, or of another
/// version than this program; shards that are missing, there twice or unfinished.
[[nodiscard]] MergedComparison merge_comparisons(const std::vector<std::filesystem::path>& folders);

/// Writes it as if it had been run in `folder`, over what there is of the same comparison. A folder that holds another
/// one is an error unless `fresh`: see `ComparisonFolder`.
void write_comparison(const std::filesystem::path& folder, const MergedComparison& merged,
                      const ComparisonResults& results, bool fresh);

}  // namespace studies
}  // namespace consimd
