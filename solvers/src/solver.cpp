#include <consimd/solvers/solver.hpp>

#include <stdexcept>
#include <string>

#include <consimd/solvers/tcf.hpp>

namespace consimd {
namespace {

constexpr SolverInfo kInfos[] = {
    {"tcf",
     "two-stage consensus filtering with pruning, re-selection over all correspondences and a posterior-weighted fit"},
    {"tcf-published", "two-stage consensus filtering, algorithms 1 to 4 of the paper to the letter"},
};

}  // namespace

std::span<const SolverInfo> solvers() noexcept { return kInfos; }

Registration register_by_name(std::string_view solver, const Correspondences& correspondences,
                              const SolverOptions& options) {
  TcfOptions tcf;
  if (solver == "tcf-published") {
    tcf = TcfOptions::as_published(options.noise_bound, options.seed);
  } else if (solver != "tcf") {
    std::string known;
    for (const SolverInfo& info : kInfos) known.append(known.empty() ? "" : ", ").append(info.name);
    throw std::invalid_argument("solver is '" + std::string(solver) + "', expected one of: " + known);
  }
  tcf.noise_bound = options.noise_bound;
  tcf.seed = options.seed;
  return register_tcf(correspondences, tcf);
}

}  // namespace consimd
