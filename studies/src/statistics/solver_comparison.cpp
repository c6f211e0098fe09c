#include <consimd/studies/solver_comparison.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <consimd/kernels/elementary_functions.hpp>

#include <consimd/studies/paired_statistics.hpp>
#include "statistics/compare_strata.hpp"

namespace consimd::studies {
namespace detail {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kShortestTime = 1e-9;  // seconds: a program may say 0, which has no logarithm
constexpr std::uint32_t kFirstThreshold = 10, kLastThreshold = 60;  // twentieths of the study's own

using Runs = std::span<const ComparedRun>;

/// A solver's runs on one problem: errors are means over its successes, time is a geometric mean.
struct OnProblem {
  std::size_t successes = 0;
  double rotation_deg = 0.0, translation = 0.0, log_seconds = 0.0;

  explicit OnProblem(Runs runs) {
    for (const ComparedRun& run : runs) {
      log_seconds += elementary::log(std::max(run.seconds, kShortestTime));
      if (!run.success) continue;
      ++successes;
      rotation_deg += run.rotation_error_deg;
      translation += run.translation_error;
    }
    log_seconds /= static_cast<double>(runs.size());
    rotation_deg /= static_cast<double>(successes);
    translation /= static_cast<double>(successes);
  }
};

}  // namespace

PairTally::PairTally(Runs a, Runs b, std::size_t runs_per_problem, std::uint64_t seed, std::uint64_t key) {
  std::vector<double> recall, rotation_deg, translation, log_seconds;
  for (std::size_t first = 0; first < a.size(); first += runs_per_problem) {
    const OnProblem of_a(a.subspan(first, runs_per_problem)), of_b(b.subspan(first, runs_per_problem));
    only_a_ += of_a.successes > of_b.successes ? 1U : 0U;
    only_b_ += of_b.successes > of_a.successes ? 1U : 0U;
    recall.push_back((static_cast<double>(of_a.successes) - static_cast<double>(of_b.successes)) /
                     static_cast<double>(runs_per_problem));
    log_seconds.push_back(of_a.log_seconds - of_b.log_seconds);
    if (of_a.successes == 0 || of_b.successes == 0) continue;
    rotation_deg.push_back(of_a.rotation_deg - of_b.rotation_deg);
    translation.push_back(of_a.translation - of_b.translation);
  }
  problems_ = recall.size();
  const auto quantity = [&](const std::vector<double>& differences) {
    Quantity of{.problems = differences.size()};
    for (const double one : differences) of.sum += one;
    of.samples = BootstrapMeans(differences.size(), seed, key).of(differences);
    for (double& mean : of.samples) mean *= static_cast<double>(differences.size());
    return of;
  };
  recall_ = quantity(recall);
  rotation_deg_ = quantity(rotation_deg);
  translation_ = quantity(translation);
  log_seconds_ = quantity(log_seconds);
}

void PairTally::Quantity::add(const Quantity& other) {
  problems += other.problems;
  sum += other.sum;
  if (other.samples.empty()) return;
  samples.resize(other.samples.size());
  std::ranges::transform(samples, other.samples, samples.begin(), std::plus<>());
}

Estimate PairTally::Quantity::mean() const {
  const auto count = static_cast<double>(problems);
  std::vector<double> means = samples;
  for (double& mean : means) mean /= count;
  return {problems == 0 ? kNaN : sum / count, bootstrap_interval(std::move(means))};
}

void PairTally::add(const PairTally& other) {
  problems_ += other.problems_;
  only_a_ += other.only_a_;
  only_b_ += other.only_b_;
  recall_.add(other.recall_);
  rotation_deg_.add(other.rotation_deg_);
  translation_.add(other.translation_);
  log_seconds_.add(other.log_seconds_);
}

PairStatistics PairTally::statistics() const {
  const auto [ratio, bounds] = log_seconds_.mean();
  return {.trials = problems_,
          .only_a = only_a_,
          .only_b = only_b_,
          .p_value = mcnemar_p_value(only_a_, only_b_),
          .recall = recall_.mean(),
          .rotation_deg = rotation_deg_.mean(),
          .translation = translation_.mean(),
          .time_ratio = {elementary::exp(ratio), {elementary::exp(bounds.low), elementary::exp(bounds.high)}}};
}

SolverStatistics solver_statistics(Runs runs) {
  std::vector<double> rotations, translations, seconds;
  // Sums of squares, over the successes that have an oracle.
  double rotation = 0.0, translation = 0.0, oracle_rotation = 0.0, oracle_translation = 0.0;
  std::size_t successes = 0;
  for (const ComparedRun& run : runs) {
    rotations.push_back(run.success ? run.rotation_error_deg : kInfinity);
    translations.push_back(run.success ? run.translation_error : kInfinity);
    seconds.push_back(run.success ? run.seconds : kInfinity);
    if (!run.success) continue;
    ++successes;
    if (std::isnan(run.oracle_rotation_error_deg)) continue;
    rotation += run.rotation_error_deg * run.rotation_error_deg;
    translation += run.translation_error * run.translation_error;
    oracle_rotation += run.oracle_rotation_error_deg * run.oracle_rotation_error_deg;
    oracle_translation += run.oracle_translation_error * run.oracle_translation_error;
  }
  return {.trials = runs.size(),
          .recall = static_cast<double>(successes) / static_cast<double>(runs.size()),
          .recall_interval = wilson_interval(successes, runs.size()),
          .rotation_deg_median = quantile(rotations, 0.5),
          .rotation_deg_p90 = quantile(rotations, 0.9),
          .translation_median = quantile(translations, 0.5),
          .translation_p90 = quantile(translations, 0.9),
          .rotation_efficiency = oracle_rotation / rotation,
          .translation_efficiency = oracle_translation / translation,
          .seconds_recall_50 = quantile(seconds, 0.5),
          .seconds_recall_90 = quantile(seconds, 0.9),
          .seconds_recall_99 = quantile(seconds, 0.99)};
}

std::vector<CurvePoint> success_curve(Runs runs) {
  std::vector<double> ratios;
  ratios.reserve(runs.size());
  for (const ComparedRun& run : runs) ratios.push_back(run.limit_ratio);
  std::ranges::sort(ratios);
  std::vector<CurvePoint> curve;
  for (std::uint32_t twentieths = kFirstThreshold; twentieths <= kLastThreshold; ++twentieths) {
    const double threshold = twentieths / 20.0;
    const auto below = static_cast<std::size_t>(std::ranges::lower_bound(ratios, threshold) - ratios.begin());
    curve.push_back({.threshold = threshold,
                     .recall = static_cast<double>(below) / static_cast<double>(runs.size()),
                     .recall_interval = wilson_interval(below, runs.size())});
  }
  return curve;
}

void adjust(const std::vector<PairStatistics*>& pairs) {
  std::vector<double> p_values;
  p_values.reserve(pairs.size());
  for (const PairStatistics* pair : pairs) p_values.push_back(pair->p_value);
  const std::vector<double> adjusted = holm_adjusted(p_values);
  for (std::size_t k = 0; k < pairs.size(); ++k) pairs[k]->p_value_holm = adjusted[k];
}

}  // namespace detail

bool differ(const PairStatistics& pair) noexcept { return pair.p_value_holm <= kSignificance; }

std::string beats(const PairStatistics& pair, const std::string& a, const std::string& b) {
  const bool first = pair.only_a > pair.only_b;
  return fmt::format("{} beats {} ({} problems to {}, p = {:.2g}, Holm's {:.2g})", first ? a : b, first ? b : a,
                     std::max(pair.only_a, pair.only_b), std::min(pair.only_a, pair.only_b), pair.p_value,
                     pair.p_value_holm);
}

}  // namespace consimd::studies
