// What a comparison runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/comparison.hpp>
#include <consimd/studies/comparison_folder.hpp>
#include <consimd/studies/scan_cases.hpp>
#include <consimd/studies/shard.hpp>
#include <consimd/studies/table_options.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Defaults: all solvers on the stand-ins, the tables "solvers", "pairs" and "quantiles".
struct CompareOptions {
  std::string cases = {};                 ///< folder of cases, see `case_folder_groups`; empty: none
  std::optional<ScanOptions> scans = {};  ///< real scans; the layout's seed is that of the data below
  /// Names of stand-ins, "stand-ins" (all), "eth", "kitti", "noise" (cells of the noise study). Empty: all stand-ins,
  /// unless there are cases or scans.
  std::vector<std::string> synthetic = {};
  std::uint32_t trials = 20;  ///< problems of each stand-in, noise cell, and scale with its noise
  std::size_t points = 3000;  ///< correspondences of a noise cell's problem
  // The axes of the noise cells, as `parse_value_list` reads them; noise in metres an axis.
  std::string outliers = "0.1,0.5,0.9,0.95,0.98,0.99";
  std::string sigma = "0.1,1,2.5,5";
  TableOptions tables;
  std::uint32_t iteration_problems = 200;  ///< of the table "iterations"
  std::uint64_t seed = 1;                  ///< of the data; synthetic problem k starts its solvers with seed + k
  std::uint32_t seeds = 1;                 ///< runs of a method on each case, with seeds one after the other

  CompareOptions();
};

/// What is told while a comparison is put together.
struct PreparationControl {
  std::function<void(std::size_t done, std::size_t all)> on_scan = {};  ///< see `scan_groups`
  std::function<void(const std::string&)> on_note = {};                 ///< a sentence on what a data set lacks
};

/// The runs that the options ask for, or those of a shard, none of them done. Throws std::invalid_argument on a bad
/// value, and what reading a folder of cases or scans throws.
[[nodiscard]] Comparison make_comparison(const CompareOptions& options,
                                         const std::optional<Shard>& shard = std::nullopt,
                                         const PreparationControl& control = {});

/// All that decides what is run, as comparison.json tells it.
[[nodiscard]] std::vector<OptionText> option_texts(const CompareOptions& options);

}  // namespace studies
}  // namespace consimd
