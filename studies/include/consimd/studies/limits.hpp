// The identifiability limit: where a wrong pose is supported by chance as well as the true one by its inliers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/shard.hpp>
#include <consimd/studies/sweep_options.hpp>
#include <consimd/studies/table_columns.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Problems without a true pose per noise level.
inline constexpr std::uint32_t kLimitProblems = 10;

/// One row of limits.csv: what chance does at a noise level. A pose is supported by the correspondences within the
/// noise bound, 3 sigma.
struct LimitRecord {
  double sigma = 0.0;
  std::uint32_t problems = 0;
  double chance_support_mean = 0.0;
  std::uint64_t chance_support_max = 0;
  double fixed_support_mean = 0.0;
  double limit_outlier_ratio = 0.0;

  bool operator==(const LimitRecord&) const = default;
};

inline constexpr std::tuple kLimitColumns{
    Column{"sigma", &LimitRecord::sigma, "standard deviation of an inlier's noise, metres an axis"},
    Column{"problems", &LimitRecord::problems, "problems without a true pose"},
    Column{"chance_support_mean", &LimitRecord::chance_support_mean,
           "supporters of the best pose that the search finds in such a problem, mean"},
    Column{"chance_support_max", &LimitRecord::chance_support_max, "the most of them in one of the problems"},
    Column{"fixed_support_mean", &LimitRecord::fixed_support_mean,
           "supporters of a pose drawn without regard to the correspondences, mean"},
    Column{"limit_outlier_ratio", &LimitRecord::limit_outlier_ratio,
           "outlier ratio at which the true pose has no more supporters than the best wrong one"},
};

/// A line with its newline. Numbers read back to the same bits.
[[nodiscard]] std::string to_csv_row(const LimitRecord& record);

/// Inverse of `to_csv_row`, the newline left out. Throws std::invalid_argument that says what is wrong.
[[nodiscard]] LimitRecord parse_limit_row(std::string_view line);

/// The outlier ratio r, in [0, 1], at which the true pose's expected support equals `chance_support`:
///   points ((1 - r) P(chi_3 < 3) + r f) = chance_support,  f = fixed_support / points,
/// where P(chi_3 < 3) = 0.9707 is the share of true inliers within 3 sigma and f that of random correspondences within
/// the bound of a given pose. A chance support below three counts as three: every pose has those that made it.
[[nodiscard]] double limit_outlier_ratio(std::size_t points, double chance_support, double fixed_support);

/// Throws std::invalid_argument on a study beyond the paper's: the limit is that of its problems.
void require_limits(const SweepOptions& options);

/// The noise levels that a shard measures, or all, in the order of the options.
[[nodiscard]] std::vector<double> limit_levels(const SweepOptions& options, const std::optional<Shard>& shard);

struct LimitControl {
  /// Called as problems end, one call at a time, from any thread of the arena.
  std::function<void()> on_problem = {};
  /// Asked before every problem, from any thread; true ends the measurement.
  std::function<bool()> stop_requested = {};
};

/// Runs the default solver on `kLimitProblems` problems of so many correspondences as the study's that are all
/// outliers, in parallel in the caller's arena. Problem k depends on (options.seed, sigma, k) alone. Nothing if it was
/// stopped.
[[nodiscard]] std::optional<LimitRecord> measure_limit(const SweepOptions& options, double sigma,
                                                       const LimitControl& control = {});

}  // namespace studies
}  // namespace consimd
