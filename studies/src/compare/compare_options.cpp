#include <consimd/studies/compare_options.hpp>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/solvers/solver.hpp>
#include <consimd/studies/case_folder.hpp>
#include <consimd/studies/table_runs.hpp>
#include <consimd/studies/value_list.hpp>
#include <consimd/synth/stand_ins.hpp>
#include "compare/table_methods.hpp"

namespace consimd::studies {
namespace {

std::vector<double> values_of(std::string_view option, const std::string& text) {
  try {
    return parse_value_list(text);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", option, error.what()));
  }
}

/// Names of stand-ins, with "stand-ins", "eth" and "kitti" spelt out, each once, in the paper's order; and whether
/// "noise" is among them.
struct Synthetic {
  std::vector<std::string> stand_ins;
  bool noise = false;
};

Synthetic synthetic_of(const std::vector<std::string>& words) {
  Synthetic result;
  const auto asked_for = [&](std::string_view word) { return std::ranges::find(words, word) != words.end(); };
  for (const synth::StandIn& s : synth::stand_ins()) {
    const std::string_view set = s.dataset == "ETH" ? "eth" : "kitti";
    if (asked_for("stand-ins") || asked_for(set) || asked_for(s.name)) result.stand_ins.emplace_back(s.name);
  }
  result.noise = asked_for("noise");
  for (const std::string& word : words) {
    if (word == "stand-ins" || word == "eth" || word == "kitti" || word == "noise") continue;
    try {
      static_cast<void>(synth::stand_in(word));
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("synthetic: {}, or stand-ins, eth, kitti, noise", error.what()));
    }
  }
  return result;
}

/// Those of scans, which the whole pipeline runs on as well.
std::vector<CaseGroup> groups_of_scans(const CompareOptions& options, const PreparationControl& control) {
  if (!options.scans) return {};
  ScanOptions scans = *options.scans;
  scans.layout.seed = options.seed;
  ScanGroups found = scan_groups(scans, options.tables.preset, control.on_scan);
  for (const std::string& note : found.notes) {
    if (control.on_note) control.on_note(note);
  }
  for (CaseGroup& group : found.groups) group.methods = scan_methods(options.tables);
  return std::move(found.groups);
}

std::vector<CaseGroup> groups_of(const CompareOptions& options, const PreparationControl& control) {
  const TableOptions& tables = options.tables;
  std::vector<CaseGroup> groups;
  const std::vector<std::string> methods = methods_of(tables);
  if (!methods.empty() || !scan_methods(tables).empty()) groups = groups_of_scans(options, control);
  if (!methods.empty()) {
    if (!options.cases.empty()) {
      std::ranges::move(case_folder_groups(options.cases, options.seed, tables.preset), std::back_inserter(groups));
    }
    std::vector<std::string> words = options.synthetic;
    if (words.empty() && options.cases.empty() && !options.scans) words = {"stand-ins"};
    const Synthetic synthetic = synthetic_of(words);
    std::ranges::move(stand_in_groups(synthetic.stand_ins, options.trials, options.seed, tables.preset),
                      std::back_inserter(groups));
    if (synthetic.noise) {
      std::ranges::move(noise_groups({.points = options.points,
                                      .outlier_ratios = values_of("outliers", options.outliers),
                                      .sigmas = values_of("sigma", options.sigma),
                                      .trials = options.trials,
                                      .seed = options.seed}),
                        std::back_inserter(groups));
    }
    for (CaseGroup& group : groups) group.methods.insert(group.methods.begin(), methods.begin(), methods.end());
  }
  if (!iteration_methods(tables).empty()) {
    groups.push_back(iteration_group(tables, options.iteration_problems, options.seed));
  }
  std::ranges::move(scale_groups(tables, options.trials, options.seed), std::back_inserter(groups));
  return groups;
}

void require_positive(std::string_view what, std::uint32_t number) {
  if (number == 0) throw std::invalid_argument(fmt::format("{}: expected at least 1, got 0", what));
}

}  // namespace

CompareOptions::CompareOptions()
    : tables{.tables = {"solvers", "pairs", "quantiles"},
             .solvers = {},
             .iterations = {1000, 3000, 10'000, 30'000, 100'000, 300'000, 1'000'000},
             .scales = {0.2, 0.5, 1.0, 2.0, 5.0}} {
  tables.solvers = solver_names();
}

Comparison make_comparison(const CompareOptions& options, const std::optional<Shard>& shard,
                           const PreparationControl& control) {
  validate(options.tables);
  if (!options.scans && !scan_methods(options.tables).empty()) {
    throw std::invalid_argument("table pipeline: it is made of scans; name their folder and its layout");
  }
  if (options.tables.filtered && !detail::wants_solvers(options.tables)) {
    throw std::invalid_argument(
        "filter: it is for the tables solvers, pairs and quantiles; boost runs with and without");
  }
  require_positive("trials", options.trials);
  require_positive("iteration problems", options.iteration_problems);
  require_positive("seeds", options.seeds);
  return {groups_of(options, control), options.seeds, options.tables.outside, shard};
}

std::vector<OptionText> option_texts(const CompareOptions& o) {
  std::vector<OptionText> texts{{"cases", o.cases},
                                {"synthetic", fmt::format("{}", fmt::join(o.synthetic, ","))},
                                {"trials", fmt::format("{}", o.trials)},
                                {"points", fmt::format("{}", o.points)},
                                {"outliers", o.outliers},
                                {"sigma", o.sigma},
                                {"table", fmt::format("{}", fmt::join(o.tables.tables, ","))},
                                {"solver", fmt::format("{}", fmt::join(o.tables.solvers, ","))},
                                {"filter", o.tables.filtered ? "tcf" : "none"},
                                {"thresholds", o.tables.preset},
                                {"iterations", fmt::format("{}", fmt::join(o.tables.iterations, ","))},
                                {"scales", fmt::format("{}", fmt::join(o.tables.scales, ","))},
                                {"iteration-problems", fmt::format("{}", o.iteration_problems)},
                                {"seed", fmt::format("{}", o.seed)},
                                {"seeds", fmt::format("{}", o.seeds)}};
  if (o.scans) std::ranges::move(scan_option_texts(*o.scans), std::back_inserter(texts));
  return texts;
}

}  // namespace consimd::studies
