#include "graph_benchmarks.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/maximal_cliques.hpp>
#include <consimd/solvers/maximum_clique.hpp>
#include <consimd/solvers/sc2_pcr.hpp>
#include <consimd/solvers/turboreg.hpp>
#include <consimd/synth/noise_study.hpp>

#include "cpu_time.hpp"
#include "mac/clique_selection.hpp"
#include "mac/compatibility_graph.hpp"

namespace consimd::bench {
namespace {

constexpr double kSigma = 1.0;
constexpr double kNoiseBound = 3.0 * kSigma;
constexpr int kCalls = 20;

/// A problem and the graphs that the solvers make of it, with their default options.
struct GraphProblem {
  explicit GraphProblem(double outlier_ratio) {
    correspondences = synth::noise_study_problem({.outlier_ratio = outlier_ratio, .sigma = kSigma}).correspondences();
    const CorrespondenceView view = correspondences;
    consistency.compute(view, 2.0 * kNoiseBound);
    separated.compute_separated(view, turboreg.length_tolerance * kNoiseBound, turboreg.separation * kNoiseBound);
    pivots = strongest_edges(separated, turboreg.pivots);
    second_order.compute(view, sc2_pcr.length_tolerance * kNoiseBound);
    seeds = confidence_seeds(view, compatibility_confidence(second_order.loose, sc2_pcr.power_iterations),
                             sc2_pcr.seed_radius * kNoiseBound, correspondences.size() / 5);
    compatibility = std::make_unique<detail::CompatibilityGraph>(make_compatibility_graph());
  }

  [[nodiscard]] detail::CompatibilityGraph make_compatibility_graph() const {
    return {correspondences, mac.compatibility_distance * kNoiseBound, mac.compatibility_threshold, mac.max_mean_degree,
            mac.seed};
  }

  TurboRegOptions turboreg{.noise_bound = kNoiseBound};
  Sc2PcrOptions sc2_pcr{.noise_bound = kNoiseBound};
  MacOptions mac{.noise_bound = kNoiseBound};
  Correspondences correspondences;
  ConsistencyMatrix consistency;  // teaser
  ConsistencyMatrix separated;    // turboreg
  std::vector<IndexPair> pivots;
  CompatibilityMatrices second_order;  // sc2_pcr
  std::vector<std::uint32_t> seeds;
  std::unique_ptr<const detail::CompatibilityGraph> compatibility;  // mac
};

const GraphProblem& problem(double outlier_ratio) {
  static std::map<double, GraphProblem> problems;
  return problems.try_emplace(outlier_ratio, outlier_ratio).first->second;
}

/// What a stage found, as words that can be compared, and whether it holds what the stage promises.
struct Found {
  std::vector<std::uint64_t> words;
  bool valid = true;
};

void append(std::span<const std::uint32_t> values, Found& found) {
  found.words.push_back(values.size());
  found.words.insert(found.words.end(), values.begin(), values.end());
}

bool is_clique(const GraphView& graph, std::span<const std::uint32_t> vertices) {
  for (std::size_t a = 0; a < vertices.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (vertices[a] == vertices[b] || !graph.adjacent(vertices[a], vertices[b])) return false;
    }
  }
  return true;
}

/// Whether no vertex of the graph is adjacent to all of a clique.
bool is_maximal(const GraphView& graph, std::span<const std::uint32_t> clique) {
  for (std::uint32_t v = 0; v < graph.size(); ++v) {
    if (std::ranges::find(clique, v) != clique.end()) continue;
    if (std::ranges::all_of(clique, [&](std::uint32_t u) { return graph.adjacent(u, v); })) return false;
  }
  return true;
}

Found clique_of(const GraphProblem& p, const MaximumCliqueOptions& options) {
  const MaximumClique clique = maximum_clique(p.consistency, options);
  Found found{{clique.nodes, clique.proven ? 1U : 0U}, is_clique(p.consistency, clique.members)};
  append(clique.members, found);
  return found;
}

Found cores(const GraphProblem& p) {
  const CoreNumbers numbers = core_numbers(p.consistency);
  Found found;
  append(numbers.core, found);
  append(numbers.order, found);
  found.valid = std::ranges::is_sorted(numbers.order, {}, [&numbers](std::uint32_t v) { return numbers.core[v]; });
  return found;
}

Found compatibility(const GraphProblem& p) {
  const detail::CompatibilityGraph graph = p.make_compatibility_graph();
  const std::span<const std::uint64_t> bits = graph.graph().bits();
  return {{bits.begin(), bits.end()}, true};
}

Found selection(const GraphProblem& p) {
  const detail::SelectedCliques selected = detail::select_cliques(*p.compatibility, p.mac);
  Found found{{selected.found}, !selected.cliques.empty()};
  for (const detail::WeightedClique& clique : selected.cliques) {
    append(clique.rows, found);
    found.words.push_back(std::bit_cast<std::uint32_t>(clique.weight));
    found.valid = found.valid && is_clique(p.compatibility->graph(), clique.rows);
  }
  append(selected.cut_short, found);
  return found;
}

Found listing(const GraphProblem& p) {
  const GraphView graph = p.compatibility->graph();
  const MaximalCliques listed =
      maximal_cliques(graph, {.min_size = 3, .max_cliques = p.mac.max_cliques, .max_nodes = p.mac.max_nodes});
  Found found{{listed.nodes}, !listed.cliques.empty()};
  for (const std::vector<std::uint32_t>& clique : listed.cliques) {
    append(clique, found);
    found.valid = found.valid && is_clique(graph, clique);
  }
  // Some of them: there are many.
  for (std::size_t c = 0; c < listed.cliques.size(); c += 1 + listed.cliques.size() / 64) {
    found.valid = found.valid && is_maximal(graph, listed.cliques[c]);
  }
  append(listed.cut_short, found);
  return found;
}

Found edges(const GraphProblem& p) {
  Found found;
  for (const IndexPair& edge : strongest_edges(p.separated, p.turboreg.pivots)) {
    found.words.push_back(std::uint64_t{edge.first} << 32 | edge.second);
    found.valid = found.valid && GraphView(p.separated).adjacent(edge.first, edge.second);
  }
  return found;
}

Found triples(const GraphProblem& p) {
  Found found;
  for (const IndexTriple& t : pivot_cliques(p.separated, p.pivots, p.turboreg.cliques_per_pivot)) {
    const std::uint32_t rows[] = {t.first, t.second, t.third};
    append(rows, found);
    found.valid = found.valid && is_clique(p.separated, rows);
  }
  return found;
}

Found seed_poses(const GraphProblem& p) {
  const SeedPoses sets = second_order_poses(p.correspondences, p.second_order, p.seeds, p.sc2_pcr);
  Found found;
  for (const WorkingPose& pose : sets.poses) {
    for (const float value : pose.rotation) found.words.push_back(std::bit_cast<std::uint32_t>(value));
    for (const float value : pose.translation) found.words.push_back(std::bit_cast<std::uint32_t>(value));
  }
  for (const IndexTriple& t : sets.leading) {
    const std::uint32_t rows[] = {t.first, t.second, t.third};
    append(rows, found);
  }
  return found;
}

struct Stage {
  const char* name;
  Found (*find)(const GraphProblem&);
  void (*call)(const GraphProblem&);  // the same without the checks
};

constexpr std::uint64_t kProof = MaximumCliqueOptions{}.max_nodes;

const Stage kStages[] = {
    {"maximum_clique", [](const GraphProblem& p) { return clique_of(p, {.max_nodes = kProof}); },
     [](const GraphProblem& p) { benchmark::DoNotOptimize(maximum_clique(p.consistency, {.max_nodes = kProof})); }},
    {"maximum_clique_greedy", [](const GraphProblem& p) { return clique_of(p, {.max_nodes = 0}); },
     [](const GraphProblem& p) { benchmark::DoNotOptimize(maximum_clique(p.consistency, {.max_nodes = 0})); }},
    {"core_numbers", cores, [](const GraphProblem& p) { benchmark::DoNotOptimize(core_numbers(p.consistency)); }},
    {"compatibility_graph", compatibility,
     [](const GraphProblem& p) { benchmark::DoNotOptimize(p.make_compatibility_graph()); }},
    {"maximal_cliques", listing,
     [](const GraphProblem& p) {
       benchmark::DoNotOptimize(maximal_cliques(
           p.compatibility->graph(), {.min_size = 3, .max_cliques = p.mac.max_cliques, .max_nodes = p.mac.max_nodes}));
     }},
    {"select_cliques", selection,
     [](const GraphProblem& p) { benchmark::DoNotOptimize(detail::select_cliques(*p.compatibility, p.mac)); }},
    {"strongest_edges", edges,
     [](const GraphProblem& p) { benchmark::DoNotOptimize(strongest_edges(p.separated, p.turboreg.pivots)); }},
    {"pivot_cliques", triples,
     [](const GraphProblem& p) {
       benchmark::DoNotOptimize(pivot_cliques(p.separated, p.pivots, p.turboreg.cliques_per_pivot));
     }},
    {"second_order_poses", seed_poses,
     [](const GraphProblem& p) {
       benchmark::DoNotOptimize(second_order_poses(p.correspondences, p.second_order, p.seeds, p.sc2_pcr));
     }},
};

void measure(benchmark::State& state, const Stage& stage, double outlier_ratio, Isa isa) {
  oneapi::tbb::task_arena(1).execute([&] {
    const GraphProblem& p = problem(outlier_ratio);
    set_active_isa(Isa::scalar);
    const Found reference = stage.find(p);
    set_active_isa(isa);
    const Found found = stage.find(p);
    if (!found.valid) {
      state.SkipWithError("not what the stage promises");
      return;
    }
    if (found.words != reference.words) {
      state.SkipWithError("differs from the scalar reference");
      return;
    }
    std::vector<double> milliseconds;
    for (auto _ : state) {
      const double start = thread_seconds();
      stage.call(p);
      const double seconds = thread_seconds() - start;
      state.SetIterationTime(seconds);
      milliseconds.push_back(1e3 * seconds);
    }
    state.counters["median_ms"] = median(milliseconds);
  });
}

}  // namespace

void register_graph_benchmarks() {
  std::vector<Isa> isas{Isa::scalar};
  if (active_isa() != Isa::scalar) isas.push_back(active_isa());
  for (const Stage& stage : kStages) {
    for (const double outlier_ratio : {0.9, 0.98}) {
      for (const Isa isa : isas) {
        const std::string name = fmt::format("graph/{}/outliers:{}/{}", stage.name, outlier_ratio, to_string(isa));
        benchmark::RegisterBenchmark(
            name.c_str(), [=, &stage](benchmark::State& state) { measure(state, stage, outlier_ratio, isa); })
            ->Iterations(kCalls)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace consimd::bench
