#include "study/study_summary.hpp"

#include "study/run_json.hpp"

namespace consimd::study {
namespace {

Json to_json(const SweepOptions& options) {
  return {{"points", options.points}, {"outliers", options.outlier_ratios}, {"sigma", options.sigmas},
          {"trials", options.trials}, {"solver", options.solvers},          {"filter", to_string(options.filter)},
          {"seed", options.seed}};
}

}  // namespace

std::string summary_json(const SweepOptions& options, const RunFacts& facts) {
  Json summary = environment_json(facts.isa, facts.threads);
  summary["options"] = to_json(options);
  summary["noise_bound"] = "3 sigma";
  summary["recall_interval"] = "Wilson, 95 %";
  summary["trials_total"] = options.cells() * options.trials;
  summary["trials_done"] = facts.trials_done;
  summary["complete"] = facts.complete;
  return summary_text(summary);
}

std::string difference(std::string_view summary, const SweepOptions& options) {
  return difference(summary, to_json(options));
}

}  // namespace consimd::study
