// A model of the residuals around a pose: inliers with tails of their own among uniform outliers.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

namespace consimd::detail {

inline constexpr std::size_t kResidualBins = 24;

/// Counts of residuals in kResidualBins equal steps from 0 to `cutoff`.
struct ResidualHistogram {
  double cutoff = 0.0;
  std::array<double, kResidualBins> counts{};
};

/// Density of residual vectors e in 3-D, |e| = r:
///   inliers * K / scale^3 * y^-exponent + outlier_density,  y = 1 + r^2 / (2 exponent scale^2),
/// K normalising the first term: a Student distribution, for exponent 64 a Gaussian of deviation `scale` an axis but
/// for a percent.
struct ResidualMixture {
  std::uint32_t exponent = 64;
  double scale = 0.0;
  double inliers = 0.0;          ///< expected number, those beyond the cutoff included
  double outlier_density = 0.0;  ///< per unit volume
  double log_likelihood = 0.0;

  /// Outlier density over inlier density at r = 0.
  [[nodiscard]] double odds() const;
};

/// Maximum likelihood by expectation maximisation for the mixture's exponent, from where it stands.
void fit_mixture(const ResidualHistogram& histogram, ResidualMixture& mixture, int rounds);

/// The most likely of the tails 64, 8, 4 and 2; a heavier one must be more likely by a margin. Each stays where its
/// last fit left it, which is a good start once the histogram changes little.
class MixtureChoice {
 public:
  MixtureChoice(const ResidualHistogram& histogram, double scale);

  const ResidualMixture& fit(const ResidualHistogram& histogram, int rounds);

 private:
  std::array<ResidualMixture, 4> candidates_;
  double least_log_likelihood_ = -std::numeric_limits<double>::infinity();
};

}  // namespace consimd::detail
