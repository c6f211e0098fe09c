// The options of pcr99.
#pragma once

#include <consimd/solvers/pcr99.hpp>

#include "call/option_list.hpp"
#include "search/matrix_sample.hpp"
#include "support/pose_ranking_names.hpp"

namespace consimd::detail {

inline const OptionList<Pcr99Options>& pcr99_options() {
  static const OptionList<Pcr99Options> list{
      option<&Pcr99Options::estimate_scale>("estimate_scale", "",
                                            "find the scale of the source as well; needs a noise bound and no filter"),
      option<&Pcr99Options::ratio_tolerance>(
          "ratio_tolerance", "", "a pair is bad when the logarithm of the ratio of its lengths exceeds it", kShare),
      option<&Pcr99Options::length_tolerance>(
          "length_tolerance", "noise bounds",
          "or when its lengths differ by so much; two keep every pair of inliers, the paper has inf",
          kPositiveOrInfinite),
      option<&Pcr99Options::ranking_tolerance>("ranking_tolerance", "noise bounds",
                                               "the same for the costs that rank correspondences; the paper has inf",
                                               kPositiveOrInfinite),
      option<&Pcr99Options::inlier_tolerance>("inlier_tolerance", "noise bounds",
                                              "residuals below it count when hypotheses are scored", kPositive),
      option<&Pcr99Options::batch>("batch", "hypotheses",
                                   "scored together; the search stops after a batch that has a significant pose", 1),
      option<&Pcr99Options::max_screened>(
          "max_screened", "triples", "of which the best connected gets a pose, at most; one in the first batch", 1),
      option<&Pcr99Options::max_hypotheses>("max_hypotheses", "hypotheses", "at most", 1),
      option<&Pcr99Options::max_triples>("max_triples", "triples", "looked at, at most", 1),
      option<&Pcr99Options::ranking>("ranking", "", "the support that ranks the hypotheses"),
      option<&Pcr99Options::matrix_budget_bytes>(
          "matrix_budget_bytes", "bytes",
          "memory for the matrix of good pairs; of more correspondences than fit, triples are those of the best-ranked",
          least_matrix_budget(1)),
  };
  return list;
}

}  // namespace consimd::detail
