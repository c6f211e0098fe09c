// Studies and comparisons as pages for people.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/comparison.hpp>
#include <consimd/studies/paper_tables.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// One self-contained HTML page that needs no network: how every solver did over all; success, errors beside the
/// oracle's and time as figures, whose points tell the numbers of their cell; several solvers beside each other, as
/// pairs, with their recall over the limit of success; all cells as a table that is sorted by a click and saved as CSV
/// or JSON; the machine and the command. Figures run over the column with the most values, noise as a rule; of the
/// columns that tell cells apart each further one that varies divides the panels. summary: the text of summary.json.
/// command: what makes the study, as it is shown. The same study gives the same bytes. Throws std::invalid_argument if
/// the summary is no JSON.
[[nodiscard]] std::string sweep_page(const StudySummary& study, std::string_view summary, std::string_view command);

/// The same of a comparison, finished or not: success with its interval and time of every method in every group of
/// cases, methods beside each other, then the tables for people. summary: the text of comparison.json.
[[nodiscard]] std::string comparison_page(const Comparison& comparison, const ComparisonResults& results,
                                          std::string_view summary, std::string_view command);

/// Throws before a study is run where its page could not be written: std::invalid_argument unless the name ends in
/// .html or .htm, std::runtime_error unless `replace_file` can write it. folder: that of the study, or empty; it is
/// made if the page lies in it.
void require_writable_page(const std::filesystem::path& page, const std::filesystem::path& folder);

}  // namespace studies
}  // namespace consimd
