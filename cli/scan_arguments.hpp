// Scans of a data set on the command line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <consimd/studies/scan_cases.hpp>
#include "cloud_arguments.hpp"

namespace consimd::cli {

/// What --scans and the options that go with it say.
struct ScanArguments {
  studies::LayoutOptions layout;
  std::string overlap;  ///< LEAST:MOST
  CloudArguments clouds;
  std::optional<double> noise_bound;
};

void add_scan_options(CLI::App& command, ScanArguments& arguments);

/// None without --scans. Correspondences are kept in `cache`. Throws std::invalid_argument that names the option on a
/// bad one, and where options of scans are given without scans.
[[nodiscard]] std::optional<studies::ScanOptions> scans_of(const CLI::App& command, const ScanArguments& arguments,
                                                           const std::string& cache);

}  // namespace consimd::cli
