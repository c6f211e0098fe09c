#include "tuning_constants.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace consimd::bench {
namespace {

using detail::TcfTuning;

template <typename Value>
void scale_value(Value& value, double factor) {
  const double scaled = static_cast<double>(value) * factor;
  if constexpr (std::is_integral_v<Value>) {
    const double least_change = factor < 1.0 ? -1.0 : 1.0;
    const auto rounded = static_cast<Value>(std::lround(scaled));
    value =
        std::max(rounded == value ? static_cast<Value>(static_cast<double>(value) + least_change) : rounded, Value{1});
  } else {
    value = static_cast<Value>(scaled);
  }
}

template <typename Stage, typename Value>
TuningConstant constant(std::string name, Stage TcfTuning::*stage, Value Stage::*member) {
  return {std::move(name), [=](const TcfTuning& tuning) { return static_cast<double>(tuning.*stage.*member); },
          [=](TcfTuning& tuning, double factor) { scale_value(tuning.*stage.*member, factor); }};
}

// A quantile is scaled by what lies above it.
TuningConstant unusual() {
  TuningConstant result = constant("two_point.unusual", &TcfTuning::two_point, &detail::TwoPointTuning::unusual);
  result.scale = [](TcfTuning& tuning, double factor) {
    tuning.two_point.unusual = 1.0 - (1.0 - tuning.two_point.unusual) * factor;
  };
  return result;
}

}  // namespace

std::vector<TuningConstant> tuning_constants() {
  using detail::PruningTuning;
  using detail::RoundTuning;
  using detail::ThreePointTuning;
  using detail::TwoPointTuning;
  using detail::WindowTuning;
  constexpr auto kRound = &TcfTuning::round;
  constexpr auto kWindow = &TcfTuning::window;
  constexpr auto kTwoPoint = &TcfTuning::two_point;
  constexpr auto kPruning = &TcfTuning::pruning;
  constexpr auto kThreePoint = &TcfTuning::three_point;
  return {constant("round.first", kRound, &RoundTuning::first),
          constant("round.largest", kRound, &RoundTuning::largest),
          constant("round.first_wave", kRound, &RoundTuning::first_wave),
          constant("window.shown", kWindow, &WindowTuning::shown),
          constant("window.first", kWindow, &WindowTuning::first),
          constant("window.slack", kWindow, &WindowTuning::slack),
          constant("window.dense", kWindow, &WindowTuning::dense),
          constant("window.largest_matrix", kWindow, &WindowTuning::largest_matrix),
          constant("window.least_matrix", kWindow, &WindowTuning::least_matrix),
          constant("two_point.sample", kTwoPoint, &TwoPointTuning::sample),
          constant("two_point.partners", kTwoPoint, &TwoPointTuning::partners),
          constant("two_point.matrix_partners", kTwoPoint, &TwoPointTuning::matrix_partners),
          constant("two_point.slack", kTwoPoint, &TwoPointTuning::slack),
          constant("two_point.support_slack", kTwoPoint, &TwoPointTuning::support_slack),
          unusual(),
          constant("two_point.many_inliers", kTwoPoint, &TwoPointTuning::many_inliers),
          constant("two_point.second_point", kTwoPoint, &TwoPointTuning::second_point),
          constant("two_point.largest_set", kTwoPoint, &TwoPointTuning::largest_set),
          constant("two_point.glances", kTwoPoint, &TwoPointTuning::glances),
          constant("two_point.glance_share", kTwoPoint, &TwoPointTuning::glance_share),
          constant("pruning.smallest_drop", kPruning, &PruningTuning::smallest_drop),
          constant("pruning.large_kept", kPruning, &PruningTuning::large_kept),
          constant("pruning.large", kPruning, &PruningTuning::large),
          constant("three_point.triples", kThreePoint, &ThreePointTuning::triples),
          constant("three_point.first_triples", kThreePoint, &ThreePointTuning::first_triples),
          constant("three_point.support_share", kThreePoint, &ThreePointTuning::support_share),
          constant("three_point.enough_share", kThreePoint, &ThreePointTuning::enough_share)};
}

}  // namespace consimd::bench
