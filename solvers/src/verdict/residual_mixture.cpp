#include "verdict/residual_mixture.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include <consimd/kernels/elementary_functions.hpp>

namespace consimd::detail {
namespace {

// Gain in log-likelihood that a heavier tail must bring, so that chance does not make a Gaussian one heavy.
constexpr double kLeastGainOfHeavierTail = 2.0;
// Tails that are so much less likely are not tried again.
constexpr double kLossOfDroppedTail = 6.0;
constexpr std::array<std::uint32_t, 4> kExponents{64, 8, 4, 2};
// A scale that changes by less than this share in a round stands still.
constexpr double kStill = 1e-4;
// Least scale, as a share of the cutoff. A few chance coincidences of small residual must not pass for the whole noise.
constexpr double kLeastScale = 1.0 / 12.0;

// K of ResidualMixture.
double normalisation(std::uint32_t exponent) {
  static const auto by_squarings = [] {
    std::array<double, 7> values{};
    for (std::size_t squarings = 1; squarings < values.size(); ++squarings) {
      const auto e = static_cast<double>(1U << squarings);
      // gamma(e) / gamma(e - 3/2), factor by factor.
      double gammas = (e - 1.0) * std::numbers::inv_sqrtpi;
      for (double j = 0.0; j < e - 2.0; ++j) gammas *= (j + 1.0) / (j + 0.5);
      const double variance = 2.0 * std::numbers::pi * e;
      values[squarings] = gammas / (variance * std::sqrt(variance));
    }
    return values;
  }();
  return by_squarings.at(static_cast<std::size_t>(std::countr_zero(exponent)));
}

double ball(double radius) { return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius; }

}  // namespace

double ResidualMixture::odds() const {
  return outlier_density * scale * scale * scale / (normalisation(exponent) * inliers);
}

ResidualMixture first_guess(const ResidualHistogram& histogram, std::uint32_t exponent, double scale) {
  // Without any residuals the mixture is one as well: it must not be of weight 0.
  const double total = std::max(std::accumulate(histogram.counts.begin(), histogram.counts.end(), 0.0), 1.0);
  return {exponent, scale, 0.5 * total, 0.5 * total / ball(histogram.cutoff), 0.0};
}

void fit_mixture(const ResidualHistogram& histogram, ResidualMixture& mixture, int rounds) {
  std::array<double, kResidualBins> volume{};
  std::array<double, kResidualBins> squared{};  // mean of the squared bounds of a bin
  for (std::size_t b = 0; b < kResidualBins; ++b) {
    const double inner = histogram.cutoff * static_cast<double>(b) / kResidualBins;
    const double outer = histogram.cutoff * static_cast<double>(b + 1) / kResidualBins;
    volume[b] = ball(outer) - ball(inner);
    squared[b] = (inner * inner + inner * outer + outer * outer) / 3.0;
  }
  const std::uint32_t exponent = mixture.exponent;
  const double k = normalisation(exponent);
  mixture.log_likelihood = 0.0;
  for (int round = 0; round <= rounds; ++round) {
    const double peak = mixture.inliers * k / (mixture.scale * mixture.scale * mixture.scale);
    const double curvature = 1.0 / (2.0 * exponent * mixture.scale * mixture.scale);
    const bool last = round == rounds;
    // Bin by bin in loops that vectorise; what is summed is summed in order.
    std::array<double, kResidualBins> y{};
    for (std::size_t b = 0; b < kResidualBins; ++b) y[b] = 1.0 + squared[b] * curvature;
    std::array<double, kResidualBins> power = y;
    for (std::uint32_t reached = 1; reached < exponent; reached *= 2) {
      for (double& p : power) p *= p;
    }
    std::array<double, kResidualBins> weights{};  // inliers in the bin
    std::array<double, kResidualBins> spreads{};
    for (std::size_t b = 0; b < kResidualBins; ++b) {
      weights[b] = histogram.counts[b] * peak / (peak + mixture.outlier_density * power[b]);
      spreads[b] = weights[b] * squared[b] / y[b];
    }
    if (last) {
      for (std::size_t b = 0; b < kResidualBins; ++b) {
        const double expected = (peak / power[b] + mixture.outlier_density) * volume[b];
        mixture.log_likelihood += histogram.counts[b] * elementary::log(expected) - expected;
      }
      break;
    }
    const double inliers = std::accumulate(weights.begin(), weights.end(), 0.0);
    const double spread = std::accumulate(spreads.begin(), spreads.end(), 0.0);
    const double outliers = std::accumulate(histogram.counts.begin(), histogram.counts.end(), 0.0) - inliers;
    const double former = mixture.scale;
    mixture.inliers = std::max(inliers, 1.0);
    mixture.outlier_density = (outliers + 0.5) / ball(histogram.cutoff);
    mixture.scale = std::max(std::sqrt(spread / (3.0 * mixture.inliers)), kLeastScale * histogram.cutoff);
    if (std::abs(mixture.scale - former) < kStill * former) rounds = std::min(rounds, round + 1);
  }
}

MixtureChoice::MixtureChoice(const ResidualHistogram& histogram, double scale) {
  for (std::size_t e = 0; e < kExponents.size(); ++e) candidates_[e] = first_guess(histogram, kExponents[e], scale);
}

const ResidualMixture& MixtureChoice::fit(const ResidualHistogram& histogram, int rounds) {
  const ResidualMixture* best = nullptr;
  for (ResidualMixture& mixture : candidates_) {
    if (mixture.log_likelihood < least_log_likelihood_) continue;
    fit_mixture(histogram, mixture, rounds);
    if (best == nullptr || mixture.log_likelihood > best->log_likelihood + kLeastGainOfHeavierTail) best = &mixture;
  }
  least_log_likelihood_ = best->log_likelihood - kLossOfDroppedTail;
  return *best;
}

}  // namespace consimd::detail
