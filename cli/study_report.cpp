#include "study_report.hpp"

#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include <consimd/studies/figures.hpp>
#include <consimd/studies/study_folder.hpp>
#include "figure_report.hpp"
#include "standard_streams.hpp"
#include "sweep_table.hpp"

namespace consimd::cli {

namespace {

/// Who beats whom, or that nobody does.
void print_pairs(const studies::TrialComparison& comparison) {
  std::string text;
  for (const studies::PairRow<studies::ProblemCell>& pair : comparison.pairs) {
    if (const std::string line = verdict(pair); !line.empty()) text += "  " + line + "\n";
  }
  fmt::print("\nSolvers on the same problems, all noise levels together (McNemar's exact test, Holm's adjustment):\n{}",
             text.empty() ? "  no difference in recall at the level 0.05\n" : text);
}

}  // namespace

void print_trials(const studies::StudySummary& summary) {
  fmt::print("\n{}\n", sweep_table(summary.ratios(), summary.wide()));
  fmt::print("Errors are means over all trials, failures included; the oracle is least squares on the true inliers.\n");
  if (summary.wide()) {
    fmt::print("Recall and errors are those of the problems with a true pose; wrong, refused and ambiguous of all.\n");
  }
  if (summary.failures().any()) {
    fmt::print("Programs failed, which counts as no pose: {}.\n", summary.failures().text());
  }
  if (const std::optional<studies::TrialComparison> comparison = summary.comparison()) print_pairs(*comparison);
  flush_standard_output();
}

void print_limits(const std::vector<studies::LimitRecord>& limits, const studies::SweepOptions& options) {
  fmt::print("\n{}\n", limit_table(limits, options.points.front()));
}

void print_files_and_draw(const std::string& folder, bool map) {
  const bool compared = std::filesystem::exists(std::filesystem::path(folder) / studies::kPairsFile);
  fmt::print("data: {0}/trials.csv, {0}/cells.csv, {0}/summary.json{1}{2}\n", folder,
             map ? fmt::format(", {}/limits.csv", folder) : "",
             compared ? fmt::format(", {0}/pairs.csv, {0}/solvers.csv, {0}/curves.csv", folder) : "");
  std::vector<std::string_view> figures{"recall", "errors"};
  if (map) figures.emplace_back("map");
  if (compared) figures.emplace_back("comparison");
  draw_and_name_figures(studies::kSweepScript, folder, figures);
}

}  // namespace consimd::cli
