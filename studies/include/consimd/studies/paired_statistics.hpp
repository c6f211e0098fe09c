// Statistics of two methods on the same trials.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/statistics.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// The two-sided p-value of McNemar's exact test (Q. McNemar, Psychometrika 12, 1947): of the trials on which one of
/// two methods alone succeeded, `only_a` were A's and `only_b` B's. If both succeed equally often each is A's with
/// probability 1/2; the p-value is that of a division as uneven as this or more. 1 without such trials. Being discrete,
/// it is below x in at most a share x of studies of equal methods.
[[nodiscard]] double mcnemar_p_value(std::size_t only_a, std::size_t only_b);

/// Holm's adjusted p-values (S. Holm, Scand. J. Statist. 6, 1979), in the order of `p_values`: with all that are below
/// x taken as differences, the chance of a single false one is at most x. Throws std::invalid_argument on a value that
/// is not in [0, 1].
[[nodiscard]] std::vector<double> holm_adjusted(const std::vector<double>& p_values);

/// The smallest value that a share `q` of the values do not exceed; infinite values, which stand for failures, count.
/// NaN without values. Throws std::invalid_argument if q is not in (0, 1] or a value is NaN.
[[nodiscard]] double quantile(std::vector<double> values, double q);

/// Means of one sample after another drawn from the same trials with replacement (the bootstrap of B. Efron, Ann.
/// Statist. 7, 1979). Sample r takes the same trials whatever is averaged, so means of several quantities, or of their
/// differences between methods, are paired.
class BootstrapMeans {
 public:
  static constexpr std::size_t kSamples = 1000;

  /// `key`: what names the trials among others, e.g. the number of their cell. The same samples for the same arguments,
  /// on every machine.
  BootstrapMeans(std::size_t trials, std::uint64_t seed, std::uint64_t key) noexcept;

  /// The mean of `values`, one per trial, in every sample. Throws std::invalid_argument on another number of values.
  [[nodiscard]] std::vector<double> of(std::span<const double> values) const;

 private:
  std::size_t trials_;
  std::uint64_t seed_;
  std::uint64_t key_;
};

/// The 95 % percentile interval of a mean: between the 2.5 % and the 97.5 % quantile of its means in samples. It holds
/// the true mean in somewhat less than 95 % of studies with few trials. NaN without samples.
[[nodiscard]] Interval bootstrap_interval(std::vector<double> means);

}  // namespace studies
}  // namespace consimd
