#include "sweep_table.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace consimd::cli {

std::string sweep_table(const std::vector<studies::RatioSummary>& rows) {
  std::size_t width = 6;
  for (const studies::RatioSummary& row : rows) width = std::max(width, row.solver.size());
  std::string text = fmt::format(
      "                  recall, %        rotation error, deg       translation error, m    worst error/oracle    "
      "time, ms\n"
      "outliers  {:<{}}     min    mean      mean  oracle              mean  oracle          rotation  transl.      "
      "median\n",
      "solver", width);
  for (const studies::RatioSummary& row : rows) {
    text += fmt::format(
        "{:>6.4g} %  {:<{}}  {:>6.2f}  {:>6.2f}  {:>8.4f} {:>8.4f}  {:>8.4f} {:>8.4f}  {:>8.2f} {:>8.2f}  {:>8.2f}\n",
        100.0 * row.outlier_ratio, row.solver, width, 100.0 * row.recall_min, 100.0 * row.recall_mean,
        row.error.rotation_deg, row.oracle_error.rotation_deg, row.error.translation, row.oracle_error.translation,
        row.worst_ratio.rotation_deg, row.worst_ratio.translation, 1e3 * row.seconds_median);
  }
  return text;
}

std::string limit_table(std::vector<studies::LimitRecord> limits, std::size_t points) {
  std::ranges::sort(limits, {}, &studies::LimitRecord::sigma);
  std::string text =
      "            support of the best     limit, where the true pose\n"
      "            wrong pose              has as much\n"
      "sigma, m      mean     most         outliers, %    inliers\n";
  for (const studies::LimitRecord& limit : limits) {
    text += fmt::format("{:>8.4g}  {:>8.1f} {:>8}  {:>18.2f}  {:>9.1f}\n", limit.sigma, limit.chance_support_mean,
                        limit.chance_support_max, 100.0 * limit.limit_outlier_ratio,
                        static_cast<double>(points) * (1.0 - limit.limit_outlier_ratio));
  }
  return text;
}

}  // namespace consimd::cli
