#include <consimd/studies/sweep.hpp>

#include "digest.hpp"

namespace consimd::golden {

void add_study(Digests& digests) {
  studies::SweepOptions options;
  options.points = {300};
  options.outlier_ratios = {0.5, 0.9};
  options.sigmas = {0.1, 2.0};
  options.trials = 3;
  options.solvers = {"tcf", "ransac"};
  studies::TrialTable table(options);
  studies::run_sweep(table);
  Digest digest;
  for (const studies::TrialRecord& r : table.records()) {
    digest.add(r.solver);
    digest.add(r.status);
    digest.add(r.seed);
    digest.add(std::uint64_t{r.trial});
    digest.add(std::uint64_t{r.success});
    for (const double value :
         {r.outlier_ratio, r.sigma, r.rmse_true_inliers, r.rotation_error_deg, r.translation_error,
          r.oracle_rotation_error_deg, r.oracle_translation_error, r.inlier_precision, r.inlier_recall}) {
      digest.add(value);
    }
  }
  digests.emplace_back("study:small", digest.value());
}

}  // namespace consimd::golden
