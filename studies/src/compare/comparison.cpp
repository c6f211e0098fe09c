#include <consimd/studies/comparison.hpp>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include <consimd/synth/metrics.hpp>

#include <consimd/studies/method.hpp>

namespace consimd::studies {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void require_csv_name(std::string_view what, std::string_view name) {
  if (!name.empty() && name.find_first_of(",\"\r\n") == std::string_view::npos) return;
  throw std::invalid_argument(
      fmt::format("{} '{}': expected a name without commas, quotes and line breaks", what, name));
}

/// The error of a pose over its limit.
double limit_ratio(const Case& tried, const CaseData& data, const Outcome& outcome, const RunRecord& record) {
  if (tried.displacement) {
    return root_mean_square_displacement(tried.displacement->information, outcome.T_target_source,
                                         data.problem.T_target_source) /
           tried.displacement->root_mean_square;
  }
  if (!tried.limits) {
    return synth::rmse_true_inliers(data.problem, outcome.T_target_source, outcome.scale) / data.noise_bound;
  }
  return std::max(record.rotation_error_deg / tried.limits->rotation_deg,
                  record.translation_error / tried.limits->translation);
}

/// Errors of least squares on the true inliers.
struct OracleErrors {
  double rotation_deg = kNaN;
  double translation = kNaN;

  OracleErrors() = default;
  explicit OracleErrors(const synth::Problem& problem) {
    constexpr std::ptrdiff_t kFewest = 3;  // that determine a pose
    if (std::ranges::count(problem.is_inlier, 1) < kFewest) return;
    const RigidTransform pose = synth::oracle(problem);
    rotation_deg = synth::rotation_error_deg(pose, problem.T_target_source);
    translation = synth::translation_error(pose, problem.T_target_source);
  }
};

/// The data of a case, read when a run first needs them.
struct Loaded {
  std::shared_ptr<const CaseData> data = {};  // outside solvers may keep the points
  Correspondences correspondences = {};
  OracleErrors oracle = {};

  void require(const Case& from) {
    if (data) return;
    data = std::make_shared<const CaseData>(from.load());
    correspondences = data->problem.correspondences();
    oracle = OracleErrors(data->problem);
  }
};

Outcome outcome_on(const Case& on, const Loaded& loaded, const CaseGroup& group, const std::string& method,
                   std::uint64_t seed, const OutsideSolvers& outside) {
  const std::optional<OutsideMethod> of_others = outside_method(outside, method);
  if (!of_others) return run_method(method, loaded.correspondences, loaded.data->noise_bound, seed);
  return run_outside(*of_others->solver, {.problem = {loaded.data, &loaded.data->problem},
                                          .correspondences = loaded.correspondences,
                                          .noise_bound = loaded.data->noise_bound,
                                          .seed = seed,
                                          .filter = of_others->filter,
                                          .name = fmt::format("{} {} with seed {}", group.name, on.name, seed)});
}

RunRecord record_of(const Outcome& outcome, const Case& on, const CaseData& data, const OracleErrors& oracle,
                    const CaseGroup& group, const std::string& method, std::uint64_t seed) {
  const synth::Problem& problem = data.problem;
  const RigidTransform& truth = problem.T_target_source;
  RunRecord record{.group = group.name, .case_name = on.name, .method = method, .seed = seed, .status = outcome.status};
  record.rotation_error_deg = outcome.has_pose ? synth::rotation_error_deg(outcome.T_target_source, truth) : kNaN;
  record.translation_error = outcome.has_pose ? synth::translation_error(outcome.T_target_source, truth) : kNaN;
  record.scale_error = outcome.has_pose ? synth::scale_error(outcome.scale, problem.scale) : kNaN;
  record.limit_ratio = outcome.has_pose ? limit_ratio(on, data, outcome, record) : kNaN;
  record.success = record.limit_ratio <= 1.0;
  record.oracle_rotation_error_deg = oracle.rotation_deg;
  record.oracle_translation_error = oracle.translation;
  record.rows = problem.size();
  record.inliers = static_cast<std::uint64_t>(std::ranges::count(problem.is_inlier, 1));
  record.kept = outcome.kept.size();
  for (const std::uint32_t row : outcome.kept) record.kept_inliers += problem.is_inlier[row];
  record.seconds = outcome.seconds;
  return record;
}

}  // namespace

Comparison::Comparison(std::vector<CaseGroup> groups, std::uint32_t runs, OutsideSolvers outside,
                       std::optional<Shard> shard)
    : groups_(std::move(groups)), runs_(runs), outside_(std::move(outside)), shard_(shard) {
  std::size_t number = 0;
  for (const CaseGroup& group : groups_) {
    require_csv_name("group", group.name);
    if (group.name == kAllGroups) {
      throw std::invalid_argument(fmt::format("group '{}': the tables call all groups together so", group.name));
    }
    for (const Case& tried : group.cases) {
      require_csv_name("case", tried.name);
      if (const bool of_others = shard_ && !shard_->owns(number++); of_others) continue;
      for (const std::string& method : group.methods) {
        for (std::uint32_t run = 0; run < runs; ++run) {
          const auto [slot, added] =
              slots_.emplace(Key(group.name, tried.name, method, tried.seed + run), slots_.size());
          if (!added)
            throw std::invalid_argument(fmt::format("{}: {} on {} is there twice", group.name, method, tried.name));
        }
      }
    }
  }
  records_.resize(slots_.size());
  filled_.resize(slots_.size(), false);
}

bool Comparison::lacks(std::size_t group, std::size_t case_index, std::string_view method, std::uint64_t seed) const {
  const CaseGroup& place = groups_[group];
  const auto slot = slots_.find(Key(place.name, place.cases[case_index].name, method, seed));
  return slot != slots_.end() && !filled_[slot->second];
}

void Comparison::put(RunRecord record) {
  const auto slot = slots_.find(Key(record.group, record.case_name, record.method, record.seed));
  if (slot == slots_.end()) {
    throw std::invalid_argument(fmt::format("{} on {} {} with seed {} is not of this comparison", record.method,
                                            record.group, record.case_name, record.seed));
  }
  if (filled_[slot->second]) return;
  records_[slot->second] = std::move(record);
  filled_[slot->second] = true;
  ++filled_count_;
}

std::vector<RunRecord> Comparison::done() const {
  std::vector<RunRecord> records;
  for (std::size_t slot = 0; slot < records_.size(); ++slot) {
    if (filled_[slot]) records.push_back(records_[slot]);
  }
  return records;
}

std::vector<RunRecord> Comparison::runs_of(std::string_view group, std::string_view method) const {
  std::vector<RunRecord> records;
  for (std::size_t slot = 0; slot < records_.size(); ++slot) {
    const RunRecord& record = records_[slot];
    if (filled_[slot] && record.group == group && record.method == method) records.push_back(record);
  }
  return records;
}

void run_comparison(Comparison& comparison, const ComparisonControl& control) {
  std::size_t most_cases = 0;
  for (const CaseGroup& group : comparison.groups()) most_cases = std::max(most_cases, group.cases.size());
  for (std::size_t k = 0; k < most_cases; ++k) {
    for (std::size_t g = 0; g < comparison.groups().size(); ++g) {
      const CaseGroup& group = comparison.groups()[g];
      if (k >= group.cases.size()) continue;
      const Case& tried = group.cases[k];
      Loaded loaded;
      for (std::uint32_t r = 0; r < comparison.runs(); ++r) {
        for (const std::string& method : group.methods) {
          const std::uint64_t seed = tried.seed + r;
          if (!comparison.lacks(g, k, method, seed)) continue;
          if (control.stop_requested && control.stop_requested()) return;
          RunRecord record;
          if (const std::optional<std::string_view> solver = pipeline_solver(method)) {
            const ScanRun run = tried.register_scans(*solver, seed);
            record = record_of(run.outcome, tried, run.data, OracleErrors(run.data.problem), group, method, seed);
          } else {
            loaded.require(tried);
            Outcome outcome;
            try {
              outcome = outcome_on(tried, loaded, group, method, seed, comparison.outside());
            } catch (const SolverStopped&) {
              continue;
            }
            if (control.on_failure && !outcome.failure.empty()) control.on_failure(outcome.failure);
            record = record_of(outcome, tried, *loaded.data, loaded.oracle, group, method, seed);
          }
          if (control.on_run) control.on_run(record);
          comparison.put(std::move(record));
        }
      }
    }
  }
}

}  // namespace consimd::studies
