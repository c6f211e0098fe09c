#include <consimd/studies/trial_table.hpp>

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace consimd::studies {
namespace {

template <typename T>
std::size_t position(const std::vector<T>& values, const T& value, std::string_view what) {
  const auto found = std::find(values.begin(), values.end(), value);
  if (found == values.end()) throw std::invalid_argument(fmt::format("{} {} is not of this study", what, value));
  return static_cast<std::size_t>(found - values.begin());
}

SweepOptions validated(SweepOptions options) {
  // However a solver's options were spelt, its name in the tables is one.
  for (std::string& solver : options.solvers) solver = SolverChoice(solver).label();
  validate(options);
  return options;
}

}  // namespace

TrialTable::TrialTable(SweepOptions options, std::optional<Shard> shard)
    : options_(validated(std::move(options))),
      shard_(shard),
      size_(options_.solvers.size() *
            (shard_ ? (problems() + shard_->count - shard_->index) / shard_->count : problems())),
      records_(options_.cells() * options_.trials),
      filled_(records_.size(), false) {}

void TrialTable::put(TrialRecord record) {
  if (record.trial >= options_.trials || record.seed != options_.seed + record.trial) {
    throw std::invalid_argument(fmt::format("trial {} with seed {} is not of this study", record.trial, record.seed));
  }
  const std::size_t ratio = position(options_.outlier_ratios, record.outlier_ratio, "outlier ratio");
  const std::size_t sigma = position(options_.sigmas, record.sigma, "noise level");
  const std::size_t index = slot(position(options_.solvers, record.solver, "solver"), ratio, sigma, record.trial);
  if (!wants(ratio, sigma, record.trial)) {
    throw std::invalid_argument(fmt::format("trial {} at outlier ratio {} and noise level {} is not of shard {}",
                                            record.trial, record.outlier_ratio, record.sigma, to_string(*shard_)));
  }
  if (filled_[index]) return;
  records_[index] = std::move(record);
  filled_[index] = true;
  ++filled_count_;
}

void TrialTable::for_each(const std::function<void(const TrialRecord&)>& take) const {
  for (std::size_t i = 0; i < records_.size(); ++i) {
    if (filled_[i]) take(records_[i]);
  }
}

}  // namespace consimd::studies
