#include <consimd/solvers/adaptive_voting.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "call/option_checks.hpp"

namespace consimd {
namespace {

struct EndPoint {
  double at;
  std::uint32_t measurement;
  bool opens;
};

/// Sums over a set of measurements from which its weighted mean and its cost follow.
struct Sums {
  double weight = 0.0;
  double value = 0.0;
  double square = 0.0;
  std::size_t size = 0;

  void add(double v, double bound) { change(v, bound, 1.0); }
  void remove(double v, double bound) {
    if (--size == 0) {
      *this = {};  // without what rounding left
      return;
    }
    ++size;
    change(v, bound, -1.0);
  }
  [[nodiscard]] double mean() const { return value / weight; }
  /// The cost of the set alone; a measurement outside it costs 1.
  [[nodiscard]] double cost() const { return std::max(square - value * value / weight, 0.0); }

 private:
  void change(double v, double bound, double sign) {
    const double w = sign / (bound * bound);
    weight += w;
    value += w * v;
    square += w * v * v;
    size = sign > 0.0 ? size + 1 : size - 1;
  }
};

}  // namespace

AdaptiveVote adaptive_voting(std::span<const double> values, std::span<const double> bounds) {
  if (bounds.size() != values.size()) detail::reject_option("bounds.size()", bounds.size(), "as many as values");
  AdaptiveVote vote;
  if (values.empty()) return vote;
  std::vector<EndPoint> ends;
  ends.reserve(2 * values.size());
  for (std::uint32_t i = 0; i < values.size(); ++i) {
    detail::require_length("bound", bounds[i]);
    if (!std::isfinite(values[i])) detail::reject_option("value", values[i], "a finite number");
    ends.push_back({values[i] - bounds[i], i, true});
    ends.push_back({values[i] + bounds[i], i, false});
  }
  std::ranges::sort(ends, [](const EndPoint& a, const EndPoint& b) {
    if (a.at != b.at) return a.at < b.at;
    if (a.opens != b.opens) return a.opens;
    return a.measurement < b.measurement;
  });

  // Squares lose fewer digits about a value in the middle.
  const double origin = ends[ends.size() / 2].at;
  const auto all = static_cast<double>(values.size());
  Sums sums;
  double least = std::numeric_limits<double>::infinity();
  double best = ends.front().at;  // a point of the best set's intervals
  for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
    const auto& [at, i, opens] = ends[e];
    if (opens) {
      sums.add(values[i] - origin, bounds[i]);
    } else {
      sums.remove(values[i] - origin, bounds[i]);
    }
    // Where end points coincide, all intervals that open there do before one closes.
    const EndPoint& next = ends[e + 1];
    if (sums.size == 0 || (at == next.at && (!opens || next.opens))) continue;
    const double cost = sums.cost() + all - static_cast<double>(sums.size);
    if (cost < least) {
      least = cost;
      best = 0.5 * (at + next.at);
    }
  }
  Sums chosen;
  for (std::uint32_t i = 0; i < values.size(); ++i) {
    if (values[i] - bounds[i] > best || values[i] + bounds[i] < best) continue;
    vote.consensus.push_back(i);
    chosen.add(values[i] - origin, bounds[i]);
  }
  vote.value = origin + chosen.mean();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double ratio = (values[i] - vote.value) / bounds[i];
    vote.cost += std::min(ratio * ratio, 1.0);
  }
  return vote;
}

}  // namespace consimd
