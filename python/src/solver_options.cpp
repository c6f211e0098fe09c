#include "solver_options.hpp"

#include <array>
#include <concepts>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include <consimd/solvers/mac.hpp>
#include <consimd/solvers/pcr99.hpp>
#include <consimd/solvers/ransac.hpp>
#include <consimd/solvers/sc2_pcr.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/solvers/tcf_published.hpp>
#include <consimd/solvers/teaser.hpp>
#include <consimd/solvers/turboreg.hpp>

#include "named_values.hpp"

namespace consimd::python {

namespace nb = nanobind;

template <>
struct NamedValues<PoseRanking> {
  static constexpr std::array kValues{Named{"inlier_count", PoseRanking::inlier_count},
                                      Named{"truncated_score", PoseRanking::truncated_score}};
};

template <>
struct NamedValues<TeaserOptions::Selection> {
  static constexpr std::array kValues{Named{"maximum_clique", TeaserOptions::Selection::maximum_clique},
                                      Named{"maximum_core", TeaserOptions::Selection::maximum_core},
                                      Named{"everything", TeaserOptions::Selection::everything}};
};

template <>
struct NamedValues<GncRotationOptions::Pairs> {
  static constexpr std::array kValues{Named{"chain", GncRotationOptions::Pairs::chain},
                                      Named{"all", GncRotationOptions::Pairs::all}};
};

namespace {

template <typename Value>
constexpr std::string_view kKind = "a number";
template <std::unsigned_integral Value>
constexpr std::string_view kKind<Value> = "a whole number >= 0";
template <>
constexpr std::string_view kKind<bool> = "True or False";
template <>
constexpr std::string_view kKind<std::optional<double>> = "a number or None";
template <typename Value>
requires std::is_enum_v<Value>
constexpr std::string_view kKind<Value> = "a name";

/// A Python value as an option's.
template <typename Value>
Value value_from(nb::handle object, std::string_view name) {
  using Taken = std::conditional_t<std::is_enum_v<Value>, std::string, Value>;
  Taken taken{};
  if (!nb::try_cast(object, taken)) {
    const std::string message = std::string(name) + " is " + nb::repr(object).c_str() + ", expected ";
    const std::string expected(kKind<Value>);
    // A number of the right type that does not fit.
    if (PyLong_Check(object.ptr()) && std::is_integral_v<Value>) throw nb::value_error((message + expected).c_str());
    throw nb::type_error((message + expected).c_str());
  }
  if constexpr (std::is_enum_v<Value>) {
    return value_named<Value>(taken, name);
  } else {
    return taken;
  }
}

template <typename Value>
nb::object to_object(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return nb::cast(name_of(value));
  } else {
    return nb::cast(value);
  }
}

template <typename Options>
struct Option {
  template <typename Value>
  Option(const char* option_name, Value Options::*member)
      : name(option_name),
        set([member, option_name](Options& options, nb::handle object) {
          options.*member = value_from<Value>(object, option_name);
        }),
        get([member](const Options& options) { return to_object(options.*member); }) {}

  std::string_view name;
  std::function<void(Options&, nb::handle)> set;
  std::function<nb::object(const Options&)> get;
};

template <typename Options>
using OptionList = std::vector<Option<Options>>;

OptionList<TcfOptions> options_of(const TcfOptions& /*of*/) {
  return {{"confidence", &TcfOptions::confidence},
          {"max_seeds", &TcfOptions::max_seeds},
          {"matrix_budget_bytes", &TcfOptions::matrix_budget_bytes}};
}

OptionList<TcfPublishedOptions> options_of(const TcfPublishedOptions& /*of*/) {
  return {{"confidence", &TcfPublishedOptions::confidence}, {"max_iterations", &TcfPublishedOptions::max_iterations}};
}

OptionList<RansacOptions> options_of(const RansacOptions& /*of*/) {
  return {{"max_iterations", &RansacOptions::max_iterations},
          {"confidence", &RansacOptions::confidence},
          {"length_tolerance", &RansacOptions::length_tolerance},
          {"local_optimisation", &RansacOptions::local_optimisation}};
}

OptionList<Sc2PcrOptions> options_of(const Sc2PcrOptions& /*of*/) {
  return {{"length_tolerance", &Sc2PcrOptions::length_tolerance},
          {"seed_radius", &Sc2PcrOptions::seed_radius},
          {"seed_share", &Sc2PcrOptions::seed_share},
          {"power_iterations", &Sc2PcrOptions::power_iterations},
          {"first_set", &Sc2PcrOptions::first_set},
          {"second_set", &Sc2PcrOptions::second_set},
          {"ranking", &Sc2PcrOptions::ranking},
          {"matrix_budget_bytes", &Sc2PcrOptions::matrix_budget_bytes}};
}

OptionList<TurboRegOptions> options_of(const TurboRegOptions& /*of*/) {
  return {{"length_tolerance", &TurboRegOptions::length_tolerance},
          {"separation", &TurboRegOptions::separation},
          {"pivots", &TurboRegOptions::pivots},
          {"cliques_per_pivot", &TurboRegOptions::cliques_per_pivot},
          {"ranking", &TurboRegOptions::ranking},
          {"matrix_budget_bytes", &TurboRegOptions::matrix_budget_bytes}};
}

OptionList<Pcr99Options> options_of(const Pcr99Options& /*of*/) {
  return {{"estimate_scale", &Pcr99Options::estimate_scale},
          {"ratio_tolerance", &Pcr99Options::ratio_tolerance},
          {"length_tolerance", &Pcr99Options::length_tolerance},
          {"ranking_tolerance", &Pcr99Options::ranking_tolerance},
          {"inlier_tolerance", &Pcr99Options::inlier_tolerance},
          {"batch", &Pcr99Options::batch},
          {"max_screened", &Pcr99Options::max_screened},
          {"max_hypotheses", &Pcr99Options::max_hypotheses},
          {"max_triples", &Pcr99Options::max_triples},
          {"ranking", &Pcr99Options::ranking},
          {"matrix_budget_bytes", &Pcr99Options::matrix_budget_bytes}};
}

OptionList<TeaserOptions> options_of(const TeaserOptions& /*of*/) {
  return {{"estimate_scale", &TeaserOptions::estimate_scale},
          {"selection", &TeaserOptions::selection},
          {"max_nodes", &TeaserOptions::max_nodes},
          {"rotation_pairs", &TeaserOptions::rotation_pairs},
          {"refine", &TeaserOptions::refine},
          {"matrix_budget_bytes", &TeaserOptions::matrix_budget_bytes}};
}

OptionList<MacOptions> options_of(const MacOptions& /*of*/) {
  return {{"compatibility_distance", &MacOptions::compatibility_distance},
          {"compatibility_threshold", &MacOptions::compatibility_threshold},
          {"second_order", &MacOptions::second_order},
          {"max_mean_degree", &MacOptions::max_mean_degree},
          {"max_cliques", &MacOptions::max_cliques},
          {"max_nodes", &MacOptions::max_nodes},
          {"max_hypotheses", &MacOptions::max_hypotheses},
          {"weighted_fit", &MacOptions::weighted_fit},
          {"matrix_budget_bytes", &MacOptions::matrix_budget_bytes}};
}

RansacOptions fixed_samples(std::uint32_t samples) {
  RansacOptions options;
  options.max_iterations = samples;
  options.confidence.reset();
  return options;
}

/// take(defaults, register function) for the named solver.
template <typename Take>
auto with_solver(std::string_view solver, const Take& take) {
  if (solver == "tcf") return take(TcfOptions(), register_tcf);
  if (solver == "tcf-published") return take(TcfPublishedOptions(), register_tcf_published);
  if (solver == "ransac") return take(RansacOptions(), register_ransac);
  if (solver == "ransac-10k") return take(fixed_samples(10'000), register_ransac);
  if (solver == "ransac-50k") return take(fixed_samples(50'000), register_ransac);
  if (solver == "sc2_pcr") return take(Sc2PcrOptions(), register_sc2_pcr);
  if (solver == "turboreg") return take(TurboRegOptions(), register_turboreg);
  if (solver == "pcr99") return take(Pcr99Options(), register_pcr99);
  if (solver == "teaser") return take(TeaserOptions(), register_teaser);
  if (solver == "mac") return take(MacOptions(), register_mac);
  std::string known;
  for (const SolverInfo& info : solvers()) known.append(known.empty() ? "" : ", ").append(info.name);
  throw std::invalid_argument("solver is '" + std::string(solver) + "', expected one of: " + known);
}

template <typename Options>
void apply(std::string_view solver, const nb::dict& given, Options& options) {
  const OptionList<Options> list = options_of(options);
  for (const auto& [key, value] : given) {
    const auto name = nb::cast<std::string>(key);
    std::string known;
    bool found = false;
    for (const Option<Options>& option : list) {
      known.append(known.empty() ? "" : ", ").append(option.name);
      if (option.name != name) continue;
      option.set(options, value);
      found = true;
    }
    if (found) continue;
    std::string message = "register() got an unexpected keyword argument '";
    message.append(name).append("'; options of the solver '").append(solver).append("': ").append(known);
    throw nb::type_error(message.c_str());
  }
}

}  // namespace

SolverCall solver_with_options(std::string_view solver, std::uint64_t seed, nb::dict given) {
  return with_solver(solver, [&](auto options, auto* solve) -> SolverCall {
    apply(solver, given, options);
    options.seed = seed;
    return [options, solve](const Correspondences& rows, double noise_bound, std::uint32_t bounds_tried) {
      auto used = options;
      used.noise_bound = noise_bound;
      // tcf-published does not test for significance.
      if constexpr (requires { used.bounds_tried; }) used.bounds_tried = bounds_tried;
      return solve(rows, used);
    };
  });
}

nb::dict default_options(std::string_view solver) {
  return with_solver(solver, [](const auto& options, auto*) {
    nb::dict defaults;
    for (const auto& option : options_of(options)) defaults[nb::cast(option.name)] = option.get(options);
    return defaults;
  });
}

}  // namespace consimd::python
