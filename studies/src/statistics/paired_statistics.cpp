#include <consimd/studies/paired_statistics.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include <fmt/format.h>

#include <consimd/kernels/elementary_functions.hpp>

namespace consimd::studies {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The SplitMix64 generator (G. Steele et al., OOPSLA 2014): its state counts up, and its finaliser spreads the bits.
class SplitMix {
 public:
  explicit SplitMix(std::uint64_t state) : state_(state) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t x = state_;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31U);
  }

  /// In {0, ..., bound - 1}; the bias of at most bound / 2^32 is far below what samples show.
  std::uint32_t below(std::uint32_t bound) { return static_cast<std::uint32_t>(((next() >> 32U) * bound) >> 32U); }

 private:
  std::uint64_t state_;
};

}  // namespace

double mcnemar_p_value(std::size_t only_a, std::size_t only_b) {
  const std::size_t few = std::min(only_a, only_b);
  const std::size_t n = only_a + only_b;
  if (only_a == only_b) return 1.0;
  // log of C(n, few) / 2^n, then the sum of the terms below it, each over the one above: C(n, k - 1) / C(n, k).
  double log_term = -static_cast<double>(n) * elementary::log(2.0);
  for (std::size_t i = 1; i <= few; ++i) {
    log_term += elementary::log(static_cast<double>(n - few + i) / static_cast<double>(i));
  }
  double sum = 1.0;
  double term = 1.0;
  for (std::size_t k = few; k > 0 && term > sum * 1e-17; --k) {
    term *= static_cast<double>(k) / static_cast<double>(n - k + 1);
    sum += term;
  }
  return std::min(1.0, 2.0 * sum * elementary::exp(log_term));
}

std::vector<double> holm_adjusted(const std::vector<double>& p_values) {
  for (const double p : p_values) {
    const bool is_probability = p >= 0.0 && p <= 1.0;
    if (!is_probability) throw std::invalid_argument(fmt::format("p-value {}: expected one in [0, 1]", p));
  }
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t k) { return p_values[k]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0.0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    largest = std::max(largest, static_cast<double>(order.size() - rank) * p_values[order[rank]]);
    adjusted[order[rank]] = std::min(1.0, largest);
  }
  return adjusted;
}

double quantile(std::vector<double> values, double q) {
  const bool is_share = q > 0.0 && q <= 1.0;
  if (!is_share) throw std::invalid_argument(fmt::format("quantile {}: expected one in (0, 1]", q));
  if (std::ranges::any_of(values, [](double value) { return std::isnan(value); })) {
    throw std::invalid_argument("quantile of values of which one is NaN");
  }
  if (values.empty()) return kNaN;
  const double count = std::ceil(q * static_cast<double>(values.size()));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max(1.0, count)) - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

BootstrapMeans::BootstrapMeans(std::size_t trials, std::uint64_t seed, std::uint64_t key) noexcept
    : trials_(trials), seed_(seed), key_(key) {}

std::vector<double> BootstrapMeans::of(std::span<const double> values) const {
  if (values.size() != trials_) {
    throw std::invalid_argument(fmt::format("{} values of {} trials", values.size(), trials_));
  }
  if (trials_ == 0) return {};
  SplitMix random(SplitMix(seed_).next() ^ key_);
  std::vector<double> means(kSamples);
  for (double& mean : means) {
    for (std::size_t i = 0; i < trials_; ++i) mean += values[random.below(static_cast<std::uint32_t>(trials_))];
    mean /= static_cast<double>(trials_);
  }
  return means;
}

Interval bootstrap_interval(std::vector<double> means) {
  if (means.empty()) return {kNaN, kNaN};
  std::ranges::sort(means);
  const auto last = static_cast<double>(means.size() - 1);
  return {means[static_cast<std::size_t>(std::floor(0.025 * last))],
          means[static_cast<std::size_t>(std::ceil(0.975 * last))]};
}

}  // namespace consimd::studies
