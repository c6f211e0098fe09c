// What the tables of a comparison are made of: methods, and cases of their own.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <consimd/studies/table_options.hpp>

namespace consimd::studies::detail {

inline constexpr std::array kStages{"1R", "2R", "3R", "1R+2R", "1R+3R", "2R+3R", "1R+2R+3R"};
inline constexpr std::array kPoses{"1R+2R+3R", "1R+2R+IRLS", "1R+2R+3R+IRLS"};
inline constexpr std::string_view kInputStage = "1R";       // the cheapest method that tells what the data are
inline constexpr std::string_view kFilterStages = "1R+2R";  // what TCF's filter keeps

inline constexpr std::string_view kIterationGroup = "2 % inliers";
inline constexpr std::string_view kIterationRival = "tcf";  // whose recall stands beside plain RANSAC's
inline constexpr double kIterationOutliers = 0.98;

[[nodiscard]] inline bool wanted(const TableOptions& options, std::string_view table) {
  return std::ranges::find(options.tables, table) != options.tables.end();
}

/// Whether a table is of the solvers themselves.
[[nodiscard]] inline bool wants_solvers(const TableOptions& options) {
  return wanted(options, "solvers") || wanted(options, "pairs") || wanted(options, "quantiles");
}

[[nodiscard]] inline std::string scale_group_name(double scale) { return fmt::format("scale {}", scale); }

/// Outside solvers are asked for rigid motions alone.
[[nodiscard]] bool finds_scale(const TableOptions& options, std::string_view solver);

}  // namespace consimd::studies::detail
