// What the summaries of studies have in common, as JSON.
#pragma once

#include <string>
#include <string_view>

#include <consimd/studies/outside_solver.hpp>
#include "files/json_text.hpp"

namespace consimd::studies {

/// Build, machine, instruction set and threads.
[[nodiscard]] Json environment_json(std::string_view isa, int threads);

/// Which outside solvers these are, by their names.
[[nodiscard]] Json outside_json(const OutsideSolvers& outside);

/// Inverse of it, without functions. Throws std::invalid_argument if `json` is something else.
[[nodiscard]] OutsideSolvers outside_of(const Json& json);

/// The text of a summary file.
[[nodiscard]] std::string summary_text(const Json& summary);

/// Compares the study that `summary`, a text of `summary_text`, describes with `options` and this build. Empty when
/// results of the two may stand in one table, else the first difference, as "it has trials 100, not 50". Throws
/// std::invalid_argument if the text is no summary.
[[nodiscard]] std::string difference(std::string_view summary, const Json& options);

}  // namespace consimd::studies
