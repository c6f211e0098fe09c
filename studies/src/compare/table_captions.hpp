// What stands above the tables of a comparison.
#pragma once

#include <string>
#include <vector>

#include <consimd/studies/comparison.hpp>
#include <consimd/studies/table_options.hpp>

namespace consimd::studies::detail {

/// Says what the data are, group by group, those of one kind together.
[[nodiscard]] std::string data_caption(const std::vector<const CaseGroup*>& groups);
/// Says what a success is.
[[nodiscard]] std::string success_caption(const TableOptions& options, const std::vector<const CaseGroup*>& groups);
/// Says how often methods ran, and which runs are missing or failed.
[[nodiscard]] std::string runs_caption(const Comparison& comparison);

}  // namespace consimd::studies::detail
