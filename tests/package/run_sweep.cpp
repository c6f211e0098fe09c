// Runs a noise study of a few problems in a folder, and the comparison of two solvers on one of them.
#include <filesystem>
#include <iostream>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/compare_options.hpp>
#include <consimd/studies/study_folder.hpp>
#include <consimd/studies/sweep.hpp>

namespace studies = consimd::studies;

int main() {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "consimd-package-sweep";
  std::filesystem::remove_all(folder);

  studies::SweepOptions options;
  options.points = {300};
  options.outlier_ratios = {0.5};
  options.sigmas = {0.1, 1.0};
  options.trials = 3;
  studies::TrialTable table(options);
  studies::StudyFolder files(folder, table, {}, false);
  studies::run_sweep(table, {.on_trial = [&](const studies::TrialRecord& record) { files.append(record); }});
  files.finish(table, {});
  const bool written = std::filesystem::exists(folder / studies::kCellsFile);
  std::filesystem::remove_all(folder);

  studies::CompareOptions compared;
  compared.synthetic = {"noise"};
  compared.points = 300;
  compared.outliers = "0.5";
  compared.sigma = "0.1";
  compared.trials = 1;
  compared.tables.solvers = {"tcf", "ransac"};
  studies::Comparison comparison = studies::make_comparison(compared);
  studies::run_comparison(comparison);

  std::size_t successes = 0;
  for (const studies::TrialRecord& trial : table.records()) successes += trial.success ? 1U : 0U;
  for (const studies::RunRecord& run : comparison.done()) successes += run.success ? 1U : 0U;
  std::cout << successes << " of " << table.size() + comparison.size() << " registrations succeeded\n";
  return written && successes == table.size() + comparison.size() ? 0 : 1;
}
