#include <consimd/solvers/two_point_ransac.hpp>

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <consimd/kernels/angle_consistency.hpp>
#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/kernels/length_consistency.hpp>

#include "bits/bit_rows.hpp"
#include "call/option_checks.hpp"
#include "sampling/sampling.hpp"
#include "search/pruning.hpp"

namespace consimd {
namespace {

struct Point {
  double x, y, z;
};

Point difference(const CorrespondenceView& view, bool in_target, std::uint32_t to, std::uint32_t from) {
  const auto at = [&](std::size_t axis, std::uint32_t k) {
    return static_cast<double>((in_target ? view.target(axis) : view.source(axis))[k]);
  };
  return {at(0, to) - at(0, from), at(1, to) - at(1, from), at(2, to) - at(2, from)};
}

double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// The edges m -> i of both clouds after laying q_m on p_m: the cosine of their angle, and the sine that bounds it.
struct EdgeAngle {
  double cosine;
  double bound_sine;

  [[nodiscard]] double angle() const { return elementary::acos(cosine); }
  [[nodiscard]] double bound() const { return elementary::asin(bound_sine); }
  // Roots and products that are never more than the angle, and never less than the bound.
  [[nodiscard]] double least_angle() const { return std::sqrt(2.0 - 2.0 * cosine); }
  [[nodiscard]] double largest_bound() const { return 0.5 * std::numbers::pi * bound_sine; }
};

EdgeAngle edge_angle(const CorrespondenceView& view, std::uint32_t m, std::uint32_t i, double bound) {
  const Point p = difference(view, false, i, m);
  const Point q = difference(view, true, i, m);
  const double length = std::sqrt(dot(p, p));
  const double cosine = dot(p, q) / (length * std::sqrt(dot(q, q)));
  return {std::clamp(cosine, -1.0, 1.0), std::min(bound / length, 1.0)};
}

// Eq. (consensus-2pt)-(beta-2pt) as printed.
bool printed_angle_consistent(const CorrespondenceView& view, std::uint32_t m, const IndexPair& pair, double bound) {
  if (m == pair.first || m == pair.second) return true;
  const EdgeAngle a = edge_angle(view, m, pair.first, bound);
  const EdgeAngle b = edge_angle(view, m, pair.second, bound);
  // Most sets have few members and most rows are far from being one: they need no inverse functions.
  constexpr double kMoreThanRounding = 1.0 + 1e-9;
  if (a.least_angle() + b.least_angle() > kMoreThanRounding * (a.largest_bound() + b.largest_bound())) return false;
  return a.angle() + b.angle() < a.bound() + b.bound();
}

}  // namespace

ConsensusSet two_point_ransac(const Correspondences& correspondences, std::span<const std::uint32_t> candidates,
                              const TwoPointOptions& options) {
  detail::require_length("consistency_bound", options.consistency_bound);
  detail::require_length("angle_bound", options.angle_bound);
  detail::require_confidence(options.confidence);
  ConsensusSet best;
  const auto size = static_cast<std::uint32_t>(candidates.size());
  if (size < 2) {
    best.members.assign(candidates.begin(), candidates.end());
    best.score = size;
    return best;
  }

  const Correspondences subset = correspondences.subset(candidates);
  const CorrespondenceView view = subset.view();
  const std::size_t words = view.words();
  std::vector<std::vector<std::uint32_t>> sets(detail::kBatch);
  struct Scratch {
    detail::SetPruner pruner;
    std::vector<std::uint64_t> bits;
  };
  tbb::enumerable_thread_specific<Scratch> scratches;

  // The set of one pair, or nothing when the pair itself is inconsistent.
  const auto evaluate = [&](std::uint64_t hypothesis, std::vector<std::uint32_t>& set) {
    set.clear();
    detail::CounterRandom random(options.seed, detail::RandomStage::two_point, hypothesis);
    const IndexPair pair = detail::draw_pair(random, size);
    Scratch& scratch = scratches.local();
    scratch.bits.resize(3 * words);
    const std::span bits(scratch.bits);
    const std::uint32_t ends[] = {pair.first, pair.second};
    std::uint32_t counts[2];
    length_consistency_bits(view, ends, options.consistency_bound, bits.first(2 * words), counts);
    const bool consistent = (bits[pair.second / kBlock] >> (pair.second % kBlock)) & 1U;
    if ((options.prune && !consistent) || std::min(counts[0], counts[1]) < best.score) return;
    for (std::size_t w = 0; w < words; ++w) bits[w] &= bits[words + w];
    if (options.angle_test == AngleTest::rotation_invariant) {
      angle_consistency_bits(view, std::span(&pair, 1), options.angle_bound, bits.last(words), std::span(counts, 1));
      for (std::size_t w = 0; w < words; ++w) bits[w] &= bits[2 * words + w];
    }
    detail::members_of(bits.first(words), set);
    if (options.angle_test == AngleTest::as_printed) {
      std::erase_if(set, [&](std::uint32_t m) {
        return !printed_angle_consistent(view, m, pair, options.angle_bound * view.scale());
      });
    }
    if (options.prune) scratch.pruner.prune(subset, set, options.consistency_bound, best.score);
  };

  std::uint64_t needed = 1;
  while (best.iterations < options.max_iterations && best.iterations <= needed) {
    tbb::parallel_for(std::uint32_t{0}, detail::kBatch,
                      [&](std::uint32_t h) { evaluate(best.iterations + h, sets[h]); });
    const std::uint64_t first = best.iterations;
    for (std::uint32_t h = 0;
         h < detail::kBatch && best.iterations < options.max_iterations && best.iterations <= needed; ++h) {
      best.iterations = first + h + 1;
      const auto score = static_cast<std::uint32_t>(sets[h].size());
      if (score < best.score) continue;
      best.score = score;
      best.members.swap(sets[h]);
      needed = detail::iterations_needed(options.confidence, static_cast<double>(score) / size, 2);
    }
  }
  for (std::uint32_t& member : best.members) member = candidates[member];
  std::sort(best.members.begin(), best.members.end());
  return best;
}

}  // namespace consimd
