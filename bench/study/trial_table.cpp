#include "study/trial_table.hpp"

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace consimd::study {
namespace {

template <typename T>
std::size_t position(const std::vector<T>& values, const T& value, std::string_view what) {
  const auto found = std::find(values.begin(), values.end(), value);
  if (found == values.end()) throw std::invalid_argument(fmt::format("{} {} is not of this study", what, value));
  return static_cast<std::size_t>(found - values.begin());
}

SweepOptions validated(SweepOptions options) {
  validate(options);
  return options;
}

}  // namespace

TrialTable::TrialTable(SweepOptions options)
    : options_(validated(std::move(options))),
      records_(options_.cells() * options_.trials),
      filled_(records_.size(), false) {}

void TrialTable::put(TrialRecord record) {
  if (record.trial >= options_.trials || record.seed != options_.seed + record.trial) {
    throw std::invalid_argument(fmt::format("trial {} with seed {} is not of this study", record.trial, record.seed));
  }
  const std::size_t index = slot(position(options_.solvers, record.solver, "solver"),
                                 position(options_.outlier_ratios, record.outlier_ratio, "outlier ratio"),
                                 position(options_.sigmas, record.sigma, "noise level"), record.trial);
  if (filled_[index]) return;
  records_[index] = std::move(record);
  filled_[index] = true;
  ++filled_count_;
}

}  // namespace consimd::study
