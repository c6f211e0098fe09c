// summary.json: what was run, by what, on what.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/shard.hpp>
#include <consimd/studies/trial_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// How far a study has come and what it runs on.
struct RunFacts {
  std::string_view isa;
  int threads = 1;
  bool complete = false;
};

/// The text of summary.json: options, number of trials, and shard of `table`.
[[nodiscard]] std::string summary_json(const TrialTable& table, const RunFacts& facts);

/// The text of summary.json of the complete `table` of a study whose shards have `summaries`: where machines, builds or
/// numbers of threads differ it lists all values, in the order of the shards.
[[nodiscard]] std::string merged_summary_json(const TrialTable& table, std::span<const std::string> summaries);

/// That of the same study before it is complete.
[[nodiscard]] std::string unfinished_summary(std::string_view summary);

/// Compares the study that `summary` (a text of `summary_json`) describes with that of `table` and this build. Empty
/// when trials of the two may stand in one table, else the first difference, as "it has trials 100, not 50". Throws
/// std::invalid_argument if the text is no summary.
[[nodiscard]] std::string difference(std::string_view summary, const TrialTable& table);

/// As above for two studies of which `table` may be another shard or all.
[[nodiscard]] std::string difference_but_shard(std::string_view summary, const SweepOptions& options);

/// What `summary` describes. Throws std::invalid_argument if the text is no summary.
[[nodiscard]] SweepOptions options_of(std::string_view summary);
[[nodiscard]] std::optional<Shard> shard_of(std::string_view summary);

}  // namespace studies
}  // namespace consimd
