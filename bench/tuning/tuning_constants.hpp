// The constants of the default search, one by one.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "search/tcf_tuning.hpp"

namespace consimd::bench {

struct TuningConstant {
  std::string name;  ///< "window.shown"
  std::function<double(const detail::TcfTuning&)> value;
  /// Multiplies it; a whole number changes by one at least and stays above 0.
  std::function<void(detail::TcfTuning&, double factor)> scale;
};

/// All of TcfTuning, in its order.
[[nodiscard]] std::vector<TuningConstant> tuning_constants();

}  // namespace consimd::bench
