#include "study_report.hpp"

#include <fmt/format.h>

#include <consimd/studies/figures.hpp>
#include "figure_report.hpp"
#include "standard_streams.hpp"
#include "sweep_table.hpp"

namespace consimd::cli {

void print_trials(const studies::StudySummary& summary) {
  fmt::print("\n{}\n", sweep_table(summary.ratios()));
  fmt::print("Errors are means over all trials, failures included; the oracle is least squares on the true inliers.\n");
  if (summary.failures().any()) {
    fmt::print("Programs failed, which counts as no pose: {}.\n", summary.failures().text());
  }
  flush_standard_output();
}

void print_limits(const std::vector<studies::LimitRecord>& limits, const studies::SweepOptions& options) {
  fmt::print("\n{}\n", limit_table(limits, options.points));
}

void print_files_and_draw(const std::string& folder, bool map) {
  fmt::print("data: {0}/trials.csv, {0}/cells.csv, {0}/summary.json{1}\n", folder,
             map ? fmt::format(", {}/limits.csv", folder) : "");
  std::vector<std::string_view> figures{"recall", "errors"};
  if (map) figures.emplace_back("map");
  draw_and_name_figures(studies::kSweepScript, folder, figures);
}

}  // namespace consimd::cli
