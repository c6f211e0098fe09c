// Putting a study together from its shards.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/limits.hpp>
#include <consimd/studies/trial_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// The folders of shards among `folders` and directly in them. Throws std::runtime_error that names a folder that
/// neither is one nor holds any.
[[nodiscard]] std::vector<std::filesystem::path> shard_folders(const std::vector<std::filesystem::path>& folders);

struct MergedStudy {
  TrialTable table;                 ///< complete
  std::vector<LimitRecord> limits;  ///< in the order of the noise levels; none if no shard has any
  std::string summary;              ///< text of summary.json
};

/// Reads the shards in `folders`, in any order, and changes nothing in them. The result has every record as its shard
/// wrote it. Throws std::runtime_error that names what is wrong: shards of different studies, divisions or versions, or
/// of another version than this program; shards that are missing, there twice or unfinished; limits of some noise
/// levels only, or of none if `need_limits`.
[[nodiscard]] MergedStudy merge_shards(const std::vector<std::filesystem::path>& folders, bool need_limits);

}  // namespace studies
}  // namespace consimd
