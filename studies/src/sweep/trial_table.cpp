#include <consimd/studies/trial_table.hpp>

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace consimd::studies {
namespace {

template <typename Places>
void number(const auto& values, Places& places) {
  for (const auto& value : values) places.emplace(value, places.size());
}

template <typename Places>
std::size_t position(const Places& places, const typename Places::key_type& value, std::string_view what) {
  const auto found = places.find(value);
  if (found == places.end()) throw std::invalid_argument(fmt::format("{} {} is not of this study", what, value));
  return found->second;
}

SweepOptions validated(SweepOptions options) {
  // However a solver's options were spelt, its name in the tables is one.
  for (std::string& solver : options.solvers) solver = solver_label(options.outside, solver);
  validate(options);
  return options;
}

}  // namespace

TrialTable::TrialTable(SweepOptions options, std::optional<Shard> shard, Keep keep)
    : options_(validated(std::move(options))),
      shard_(shard),
      wide_(options_.beyond_paper()),
      conditions_(options_.conditions()),
      size_(options_.solvers.size() *
            (shard_ ? (problems() + shard_->count - shard_->index) / shard_->count : problems())),
      records_(keep == Keep::records ? slots() : 0),
      filled_(slots(), false) {
  number(options_.outlier_ratios, ratios_);
  number(options_.sigmas, sigmas_);
  number(options_.solvers, solvers_);
}

std::size_t TrialTable::condition_of(const TrialRecord& record) const {
  if (!wide_) return 0;
  const Condition condition{record.family, scale_knowledge_by_name(record.scale), record.points,
                            parse_bound_factor(record.bound_factor)};
  const auto found = std::ranges::find(conditions_, condition);
  if (found == conditions_.end()) {
    throw std::invalid_argument(
        fmt::format("family {} with scale {}, {} points and bound factor {} is not of this study", record.family,
                    record.scale, record.points, record.bound_factor));
  }
  if (record.true_pose != options_.has_true_pose(record.trial)) {
    throw std::invalid_argument(
        fmt::format("trial {} has {} true pose in this study", record.trial, record.true_pose ? "no" : "a"));
  }
  return static_cast<std::size_t>(found - conditions_.begin());
}

std::size_t TrialTable::slot_of(const TrialRecord& record) const {
  if (record.trial >= options_.trials || record.seed != options_.seed + record.trial) {
    throw std::invalid_argument(fmt::format("trial {} with seed {} is not of this study", record.trial, record.seed));
  }
  const std::size_t ratio = position(ratios_, record.outlier_ratio, "outlier ratio");
  const std::size_t sigma = position(sigmas_, record.sigma, "noise level");
  const std::size_t cell =
      (condition_of(record) * options_.outlier_ratios.size() + ratio) * options_.sigmas.size() + sigma;
  const std::size_t index = slot(position(solvers_, record.solver, "solver"), cell, record.trial);
  if (!wants(cell, record.trial)) {
    throw std::invalid_argument(fmt::format("trial {} at outlier ratio {} and noise level {} is not of shard {}",
                                            record.trial, record.outlier_ratio, record.sigma, to_string(*shard_)));
  }
  return index;
}

void TrialTable::put(TrialRecord record) {
  const std::size_t index = slot_of(record);
  if (filled_[index]) return;
  if (!records_.empty()) records_[index] = std::move(record);
  filled_[index] = true;
  ++filled_count_;
}

void TrialTable::for_each(const std::function<void(const TrialRecord&)>& take) const {
  for (std::size_t i = 0; i < records_.size(); ++i) {
    if (filled_[i]) take(records_[i]);
  }
}

}  // namespace consimd::studies
