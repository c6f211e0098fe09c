// comparison.json: what was run, on what data, by what, on what.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/studies/comparison.hpp>
#include <consimd/studies/comparison_folder.hpp>
#include <consimd/studies/shard.hpp>
#include <consimd/studies/table_options.hpp>
#include "files/json_text.hpp"

namespace consimd::studies::detail {

inline constexpr std::string_view kRunsFile = "runs.csv";
inline constexpr std::string_view kComparisonFile = "comparison.json";

/// The options, outside solvers among them, as the file has them.
[[nodiscard]] Json options_json(const std::vector<OptionText>& options, const OutsideSolvers& outside);

/// All of it. `environment`: what `environment_json` makes, or several of these merged. Of a shard it holds the groups
/// with all their cases as well, so that a merge needs no data.
[[nodiscard]] Json comparison_json(Json environment, Json options, const Comparison& comparison);

/// The first difference of what `text`, a comparison.json, tells to the comparison: an option, the version, shard, a
/// case, a solver's options. Empty where runs of both may stand in one table. Throws std::invalid_argument if the text
/// is no such file.
[[nodiscard]] std::string comparison_difference(std::string_view text, const Json& options,
                                                const Comparison& comparison);

/// "consimd 0.1.0 (4e3db265bf2a), avx512 on 1 thread, GNU 12.2.0, AMD EPYC." Where several were merged it lists all.
[[nodiscard]] std::string environment_line(const Json& summary);

/// The shard that a comparison.json is of; none if it is that of a whole one. Throws std::invalid_argument as above.
[[nodiscard]] std::optional<Shard> comparison_shard(std::string_view text);

/// What the comparison.json of a shard tells of the whole. Throws std::invalid_argument as above.
struct ShardedComparison {
  Json summary;
  std::vector<CaseGroup> groups;  ///< their cases cannot be read
  std::uint32_t runs = 1;
  TableOptions tables;
};
[[nodiscard]] ShardedComparison sharded_comparison(std::string_view text);

}  // namespace consimd::studies::detail
