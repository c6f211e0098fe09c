// A comparison that takes a fraction of a second.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <consimd/studies/comparison.hpp>

namespace consimd::studies {

/// Two pairs of two stand-ins, two seeds each.
inline Comparison small_comparison(const std::vector<std::string>& methods = {"tcf", "1R+2R"}) {
  std::vector<CaseGroup> groups = stand_in_groups({"facade", "office"}, 2, 5, "case");
  for (CaseGroup& group : groups) group.methods = methods;
  return {std::move(groups), 2};
}

/// The runs with their times set to zero, as text: NaN equals NaN there.
inline std::vector<std::string> timeless(const Comparison& comparison) {
  std::vector<std::string> rows;
  for (RunRecord run : comparison.done()) {
    run.seconds = 0.0;
    rows.push_back(to_csv_row(run));
  }
  return rows;
}

}  // namespace consimd::studies
