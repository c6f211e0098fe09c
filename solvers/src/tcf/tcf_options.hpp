// The options of tcf and tcf-published.
#pragma once

#include <consimd/solvers/tcf.hpp>
#include <consimd/solvers/tcf_published.hpp>

#include "call/option_list.hpp"

namespace consimd::detail {

inline const OptionList<TcfOptions>& tcf_options() {
  static const OptionList<TcfOptions> list{
      option<&TcfOptions::confidence>(
          "confidence", "probability",
          "that a seed of the pose with the largest support has been drawn when the search stops", kProbability),
      option<&TcfOptions::max_seeds>(
          "max_seeds", "seeds",
          "drawn at most; when they end before the confidence is reached the status is budget_exhausted", 1),
      option<&TcfOptions::matrix_budget_bytes>(
          "matrix_budget_bytes", "bytes",
          "memory for the consistency matrix of all rows, which is built only where consensus sets are dense"),
  };
  return list;
}

inline const OptionList<TcfPublishedOptions>& tcf_published_options() {
  static const OptionList<TcfPublishedOptions> list{
      option<&TcfPublishedOptions::confidence>(
          "confidence", "probability", "that a sample of the best set has been drawn when a stage stops", kProbability),
      option<&TcfPublishedOptions::max_iterations>("max_iterations", "samples", "drawn at most, in each stage", 1),
  };
  return list;
}

}  // namespace consimd::detail
