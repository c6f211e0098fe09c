#include "sweep_table.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

namespace consimd::cli {

namespace {

/// The family, and what differs from the paper's where any row does.
class ConditionColumn {
 public:
  explicit ConditionColumn(const std::vector<studies::RatioSummary>& rows) {
    const auto any = [&](const auto& differs) {
      return std::ranges::any_of(rows, [&](const studies::RatioSummary& row) { return differs(row.condition); });
    };
    const std::size_t points = rows.empty() ? 0 : rows.front().condition.points;
    points_ = any([&](const studies::Condition& c) { return c.points != points; });
    bound_ = any([](const studies::Condition& c) { return c.bound_factor != studies::BoundFactor(1.0); });
    scale_ = any([](const studies::Condition& c) { return c.scale == studies::ScaleKnowledge::unknown; });
    for (const studies::RatioSummary& row : rows) width_ = std::max(width_, text(row).size());
  }

  [[nodiscard]] std::string text(const studies::RatioSummary& row) const {
    const studies::Condition& condition = row.condition;
    std::string text = condition.family;
    if (scale_) text += fmt::format(", scale {}", to_string(condition.scale));
    if (points_) text += fmt::format(", {} points", condition.points);
    if (bound_)
      text +=
          fmt::format(", bound {}{}", condition.bound_factor ? "x " : "", studies::to_string(condition.bound_factor));
    return text;
  }
  [[nodiscard]] std::size_t width() const noexcept { return width_; }

 private:
  bool points_ = false;
  bool bound_ = false;
  bool scale_ = false;
  std::size_t width_ = 6;
};

}  // namespace

std::string sweep_table(const std::vector<studies::RatioSummary>& rows, bool wide) {
  std::size_t width = 6;
  for (const studies::RatioSummary& row : rows) width = std::max(width, row.solver.size());
  const ConditionColumn conditions(rows);
  const auto condition = [&](std::string_view text) {
    return wide ? fmt::format("{:<{}}", text, conditions.width() + 2) : std::string();
  };
  std::string text = fmt::format(
      "{}                  recall, %        rotation error, deg       translation error, m    worst error/oracle    "
      "time, ms{}\n"
      "{}outliers  {:<{}}     min    mean      mean  oracle              mean  oracle          rotation  transl.      "
      "median{}\n",
      condition(""), wide ? "  of all trials, %" : "", condition("family"), "solver", width,
      wide ? "   wrong  refused  ambiguous" : "");
  for (const studies::RatioSummary& row : rows) {
    text += fmt::format(
        "{}{:>6.4g} %  {:<{}}  {:>6.2f}  {:>6.2f}  {:>8.4f} {:>8.4f}  {:>8.4f} {:>8.4f}  {:>8.2f} {:>8.2f}  {:>8.2f}",
        condition(conditions.text(row)), 100.0 * row.outlier_ratio, row.solver, width, 100.0 * row.recall_min,
        100.0 * row.recall_mean, row.error.rotation_deg, row.oracle_error.rotation_deg, row.error.translation,
        row.oracle_error.translation, row.worst_ratio.rotation_deg, row.worst_ratio.translation,
        1e3 * row.seconds_median);
    if (wide) {
      text += fmt::format("  {:>6.2f}  {:>7.2f}  {:>9.2f}", 100.0 * row.outcomes.wrong, 100.0 * row.outcomes.refused,
                          100.0 * row.outcomes.ambiguous);
    }
    text += '\n';
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
