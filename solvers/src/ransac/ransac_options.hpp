// The options of ransac.
#pragma once

#include <consimd/solvers/ransac.hpp>

#include "call/option_list.hpp"

namespace consimd::detail {

inline const OptionList<RansacOptions>& ransac_options() {
  static const OptionList<RansacOptions> list{
      option<&RansacOptions::max_iterations>("max_iterations", "samples",
                                             "drawn at most; those that the length check turns down count", 1),
      option<&RansacOptions::confidence>(
          "confidence", "probability",
          "that a sample of the best pose's supporters has been drawn when the search stops; none: it draws "
          "max_iterations",
          kProbability),
      option<&RansacOptions::length_tolerance>("length_tolerance", "noise bounds",
                                               "only samples whose lengths differ by less between the clouds are "
                                               "fitted; from 2 on every sample of inliers is",
                                               kPositiveOrInfinite),
      option<&RansacOptions::local_optimisation>(
          "local_optimisation", "", "refit the poses of promising samples to their supporters (LO-RANSAC)"),
  };
  return list;
}

}  // namespace consimd::detail
