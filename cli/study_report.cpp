#include "study_report.hpp"

#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>

#include "study/cell_summary.hpp"
#include "study/figures.hpp"
#include "sweep_table.hpp"

namespace consimd::cli {
namespace {

std::filesystem::path program() {
  std::error_code unknown;
  return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

}  // namespace

void print_trials(const study::TrialTable& table) {
  fmt::print("\n{}\n", sweep_table(study::summarise_ratios(table)));
  fmt::print("Errors are means over all trials, failures included; the oracle is least squares on the true inliers.\n");
  std::fflush(stdout);
}

void print_limits(const std::vector<study::LimitRecord>& limits, const study::SweepOptions& options) {
  fmt::print("\n{}\n", limit_table(limits, options.points));
}

void print_files_and_draw(const std::string& folder, bool map) {
  fmt::print("data: {0}/trials.csv, {0}/cells.csv, {0}/summary.json{1}\n", folder,
             map ? fmt::format(", {}/limits.csv", folder) : "");
  std::fflush(stdout);
  try {
    study::draw_figures(folder, program());
    fmt::print("figures: {0}/recall.svg, {0}/errors.svg{1} (and .png)\n", folder,
               map ? fmt::format(", {}/map.svg", folder) : "");
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "consimd: figures not drawn: {}\n", error.what());
  }
}

}  // namespace consimd::cli
