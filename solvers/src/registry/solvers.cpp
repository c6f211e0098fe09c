// The solvers of this library, each written down once.
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <consimd/solvers/registry.hpp>

#include "call/option_list.hpp"
#include "mac/mac_options.hpp"
#include "pcr99/pcr99_options.hpp"
#include "ransac/ransac_options.hpp"
#include "sc2_pcr/sc2_pcr_options.hpp"
#include "tcf/tcf_options.hpp"
#include "teaser/teaser_options.hpp"
#include "turboreg/turboreg_options.hpp"

namespace consimd {
namespace {

/// What a solver has beside a name, its options, and how to run it.
struct Facts {
  std::string description;
  std::string needs = {};
  std::string memory;
  std::string stops_early;
  std::string advice;
  std::vector<Preset> presets = {};
};

/// The entry of a solver with an options struct.
template <typename Options>
Solver entry(std::string name, Facts facts, const detail::OptionList<Options>& list,
             Registration (*solve)(const Correspondences&, const Options&), const Options& defaults = {}) {
  Solver solver{.name = std::move(name),
                .description = std::move(facts.description),
                .needs = std::move(facts.needs),
                .memory = std::move(facts.memory),
                .stops_early = std::move(facts.stops_early),
                .advice = std::move(facts.advice),
                .options = {},
                .presets = std::move(facts.presets),
                .run = {}};
  for (const detail::ListedOption<Options>& listed : list) {
    solver.options.push_back(listed.option);
    solver.options.back().default_value = listed.get(defaults);
  }
  solver.run = [&list, solve, defaults](const Correspondences& correspondences, const SolverTask& task,
                                        std::span<const OptionSetting> settings) {
    Options options = defaults;
    options.noise_bound = task.noise_bound;
    options.seed = task.seed;
    options.threads = task.threads;
    options.stop = task.stop;
    options.bounds_tried = task.bounds_tried;
    for (const OptionSetting& setting : settings) {
      for (const detail::ListedOption<Options>& listed : list) {
        if (listed.option.name == setting.name) listed.set(options, setting.value);
      }
    }
    return solve(correspondences, options);
  };
  return solver;
}

Preset samples(std::string name, const std::string& in_words, std::uint64_t count) {
  return {.name = std::move(name),
          .description = "ransac with exactly " + in_words + " samples",
          .settings = {{"max_iterations", count}, {"confidence", std::monostate()}}};
}

std::vector<Solver> table() {
  const std::string linear = "linear", no_search = "no search to stop";
  std::vector<Solver> all;
  all.push_back(entry(
      "tcf",
      {.description = "two-stage consensus filtering with pruning, re-selection over all "
                      "correspondences and a posterior-weighted fit",
       .memory = "linear; a matrix of 3072 rows (1.2 MB), all rows, or a matrix of 8192, only when nothing was found",
       .stops_early = "yes",
       .advice = "always first"},
      detail::tcf_options(), register_tcf));
  all.push_back(entry("tcf-published",
                      {.description = "two-stage consensus filtering, algorithms 1 to 4 of the paper to the letter",
                       .needs = "clouds hardly rotated",
                       .memory = linear,
                       .stops_early = "yes",
                       .advice = "for comparison with the paper only"},
                      detail::tcf_published_options(), register_tcf_published));
  all.push_back(
      entry("ransac",
            {.description = "three-point RANSAC with length check and local optimisation: at most 50 000 samples",
             .needs = "up to 95 % outliers",
             .memory = linear,
             .stops_early = "yes",
             .advice = "as a baseline",
             .presets = {samples("ransac-10k", "10 000", 10'000), samples("ransac-50k", "50 000", 50'000)}},
            detail::ransac_options(), register_ransac));
  all.push_back(entry("sc2_pcr",
                      {.description = "second-order spatial compatibility: consensus sets of confident seeds",
                       .memory = "2 N^2 bits, samples beyond the budget",
                       .stops_early = no_search,
                       .advice = "a deterministic second opinion, surest at 99 %"},
                      detail::sc2_pcr_options(), register_sc2_pcr));
  all.push_back(entry("turboreg",
                      {.description = "three-cliques of the edges with most common neighbours",
                       .memory = "N^2 bits, samples beyond the budget",
                       .stops_early = no_search,
                       .advice = "a deterministic second opinion"},
                      detail::turboreg_options(), register_turboreg));
  all.push_back(entry("pcr99",
                      {.description = "triples in the order of how well their pairs agree in length with all others; "
                                      "known or unknown scale",
                       .memory = "N^2 bits, the best-ranked rows beyond the budget",
                       .stops_early = "yes",
                       .advice = "an unknown scale"},
                      detail::pcr99_options(), register_pcr99));
  all.push_back(entry("teaser",
                      {.description = "maximum clique of pairs that agree in length, rotation by graduated "
                                      "non-convexity, translation by votes; known or unknown scale",
                       .needs = "few thousand correspondences",
                       .memory = "N^2 bits, an error beyond the budget",
                       .stops_early = "yes",
                       .advice = "a proven maximum clique"},
                      detail::teaser_options(), register_teaser));
  all.push_back(entry("mac",
                      {.description = "poses of the heaviest maximal cliques of compatible correspondences, the best "
                                      "by its score on all",
                       .needs = "sparse graphs are quickest",
                       .memory = "N^2 bits, an error beyond the budget",
                       .stops_early = "yes",
                       .advice = "many hypotheses, of cliques"},
                      detail::mac_options(), register_mac));
  return all;
}

}  // namespace

std::span<const Solver> solvers() {
  static const std::vector<Solver> all = table();
  return all;
}

}  // namespace consimd
