// Kernels that find who agrees with a hypothesis: lengths, angles, residuals.
#include <vector>

#include <nanobind/stl/tuple.h>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/angle_consistency.hpp>
#include <consimd/kernels/length_consistency.hpp>
#include <consimd/kernels/length_ratio.hpp>

#include "array_arguments.hpp"
#include "array_results.hpp"
#include "bindings.hpp"

namespace consimd::python {
namespace {

using Counts = Array<std::uint32_t, -1>;
using BitsAndCounts = std::tuple<Array<std::uint64_t, -1, -1>, Counts>;

/// kernel(counts) fills a count for each hypothesis.
template <typename Kernel>
Counts counts_of(std::size_t hypotheses, const Kernel& kernel) {
  std::vector<std::uint32_t> counts(hypotheses);
  {
    const nb::gil_scoped_release unlocked;
    kernel(counts);
  }
  return to_array(std::move(counts));
}

/// kernel(bits, counts) fills a row of words and a count for each hypothesis.
template <typename Kernel>
BitsAndCounts bits_of(std::size_t hypotheses, const Correspondences& rows, const Kernel& kernel) {
  const std::size_t words = rows.view().words();
  std::vector<std::uint64_t> bits(hypotheses * words);
  std::vector<std::uint32_t> counts(hypotheses);
  {
    const nb::gil_scoped_release unlocked;
    kernel(bits, counts);
  }
  return {to_array<Array<std::uint64_t, -1, -1>>(std::move(bits), {hypotheses, words}), to_array(std::move(counts))};
}

std::vector<IndexPair> pairs_from(ArrayLike pairs) {
  const std::vector<std::uint32_t> indices = indices_from(pairs, "pairs", 2);
  std::vector<IndexPair> result;
  for (std::size_t k = 0; k < indices.size(); k += 2) result.push_back({indices[k], indices[k + 1]});
  return result;
}

Counts bound_length_counts(const SharedCorrespondences& c, ArrayLike seeds_like, double bound) {
  const std::vector<std::uint32_t> seeds = indices_from(seeds_like, "seeds");
  return counts_of(seeds.size(), [&](auto& counts) { length_consistency_counts(*c.rows, seeds, bound, counts); });
}

BitsAndCounts bound_length_bits(const SharedCorrespondences& c, ArrayLike seeds_like, double bound) {
  const std::vector<std::uint32_t> seeds = indices_from(seeds_like, "seeds");
  return bits_of(seeds.size(), *c.rows,
                 [&](auto& bits, auto& counts) { length_consistency_bits(*c.rows, seeds, bound, bits, counts); });
}

Counts bound_angle_counts(const SharedCorrespondences& c, ArrayLike pairs_like, double bound) {
  const std::vector<IndexPair> pairs = pairs_from(pairs_like);
  return counts_of(pairs.size(), [&](auto& counts) { angle_consistency_counts(*c.rows, pairs, bound, counts); });
}

BitsAndCounts bound_angle_bits(const SharedCorrespondences& c, ArrayLike pairs_like, double bound) {
  const std::vector<IndexPair> pairs = pairs_from(pairs_like);
  return bits_of(pairs.size(), *c.rows,
                 [&](auto& bits, auto& counts) { angle_consistency_bits(*c.rows, pairs, bound, bits, counts); });
}

Counts bound_alignment_counts(const SharedCorrespondences& c, ArrayLike poses_like, double bound) {
  const std::vector<WorkingPose> poses = working_poses_from(poses_like);
  return counts_of(poses.size(), [&](auto& counts) { alignment_counts(*c.rows, poses, bound, counts); });
}

std::tuple<Counts, Array<float, -1>> bound_alignment_scores(const SharedCorrespondences& c, ArrayLike poses_like,
                                                            double bound) {
  const std::vector<WorkingPose> poses = working_poses_from(poses_like);
  std::vector<PoseSupport> support(poses.size());
  {
    const nb::gil_scoped_release unlocked;
    alignment_scores(*c.rows, poses, bound, support);
  }
  std::vector<std::uint32_t> counts;
  std::vector<float> scores;
  for (const PoseSupport& pose : support) {
    counts.push_back(pose.count);
    scores.push_back(pose.score);
  }
  return {to_array(std::move(counts)), to_array(std::move(scores))};
}

BitsAndCounts bound_alignment_bits(const SharedCorrespondences& c, ArrayLike poses_like, double bound) {
  const std::vector<WorkingPose> poses = working_poses_from(poses_like);
  return bits_of(poses.size(), *c.rows,
                 [&](auto& bits, auto& counts) { alignment_bits(*c.rows, poses, bound, bits, counts); });
}

Array<float, -1> bound_alignment_residuals(const SharedCorrespondences& c, ArrayLike pose_like) {
  const WorkingPose pose = working_pose_from(pose_like);
  std::vector<float> squared(c.rows->view().padded_size());
  {
    const nb::gil_scoped_release unlocked;
    alignment_residuals(*c.rows, pose, squared);
  }
  squared.resize(c.rows->size());
  return to_array(std::move(squared));
}

Array<float, -1> bound_length_disagreement(const SharedCorrespondences& c, ArrayLike seeds_like, double bound,
                                           double ratio_bound) {
  const std::vector<std::uint32_t> seeds = indices_from(seeds_like, "seeds");
  std::vector<float> costs(seeds.size());
  {
    const nb::gil_scoped_release unlocked;
    length_disagreement(*c.rows, seeds, bound, ratio_bound, costs);
  }
  return to_array(std::move(costs));
}

std::tuple<Array<float, -1>, Array<float, -1>> bound_scale_intervals(const SharedCorrespondences& c, std::uint32_t seed,
                                                                     double bound) {
  std::vector<float> lows(c.rows->view().words() * kBlock), highs(lows.size());
  {
    const nb::gil_scoped_release unlocked;
    scale_intervals(*c.rows, seed, bound, lows, highs);
  }
  lows.resize(c.rows->size());
  highs.resize(c.rows->size());
  return {to_array(std::move(lows)), to_array(std::move(highs))};
}

Counts bound_mismatched_counts(const SharedCorrespondences& c, ArrayLike pose_like, double bound,
                               ArrayLike shifts_like) {
  const WorkingPose pose = working_pose_from(pose_like);
  const std::vector<std::uint32_t> shifts = indices_from(shifts_like, "shifts");
  return counts_of(shifts.size(), [&](auto& counts) { mismatched_counts(*c.rows, pose, bound, shifts, counts); });
}

}  // namespace

void bind_consensus_kernels(nb::module_& module) {
  const nb::arg c("correspondences");
  const nb::arg bound("bound");
  module.def("length_consistency_counts", &bound_length_counts, c, nb::arg("seeds"), bound,
             "Number of correspondences j that are length consistent with each seed k,\n"
             "    | |p_j - p_k| - |q_j - q_k| | < bound.\n"
             "seeds: (S,) rows; bound: caller's unit, > 0. Returns (S,) uint32.");
  module.def("length_consistency_bits", &bound_length_bits, c, nb::arg("seeds"), bound,
             "As length_consistency_counts, with the consistent ones: returns bits (S, words) uint64, which\n"
             "kernels.unpack_bits makes a mask of, and counts (S,) uint32.");
  module.def(
      "angle_consistency_counts", &bound_angle_counts, c, nb::arg("pairs"), bound,
      "Number of correspondences m that are angle consistent with each pair (i, j),\n"
      "    | angle(p_i p_m p_j) - angle(q_i q_m q_j) | < asin(bound / |p_m - p_i|) + asin(bound / |p_m - p_j|).\n"
      "pairs: (S, 2) rows; bound: caller's unit, > 0. Returns (S,) uint32.");
  module.def("angle_consistency_bits", &bound_angle_bits, c, nb::arg("pairs"), bound,
             "As angle_consistency_counts, with bits (S, words) uint64 before the counts.");
  module.def("length_disagreement", &bound_length_disagreement, c, nb::arg("seeds"), bound, nb::arg("ratio_bound"),
             "Sum over all j of min(d_kj, 1) for each seed k: with A and B the lengths of the pair (k, j) in the two\n"
             "clouds, d_kj = |B^2 - A^2| / min(ratio_bound (A^2 + B^2), bound (A + B)), 0 where both are zero.\n"
             "seeds: (S,) rows; bound: caller's unit, > 0; ratio_bound: in (0, 1), tanh of a bound on |ln(B / A)|.\n"
             "Returns (S,) float32.");
  module.def("scale_intervals", &bound_scale_intervals, c, nb::arg("seed"), bound,
             "The scales s of the source at which each correspondence j is length consistent with one row `seed`,\n"
             "|B - s A| < bound with A and B the lengths of the pair: returns the lows max(B - bound, 0) / A and the\n"
             "highs (B + bound) / A, (N,) float32 each, not finite where A is zero. bound: caller's unit, > 0.");
  module.def("alignment_counts", &bound_alignment_counts, c, nb::arg("poses"), bound,
             "Number of correspondences with | R p + t - q | < bound under each pose.\n"
             "poses: (H, 3, 4) [R | t], working frame; bound: caller's unit, > 0. Returns (H,) uint32.");
  module.def(
      "alignment_scores", &bound_alignment_scores, c, nb::arg("poses"), bound,
      "Counts, (H,) uint32, as alignment_counts, and truncated quadratic scores sum(1 - r^2 / bound^2) over the\n"
      "supporters (MSAC), (H,) float32.");
  module.def("alignment_bits", &bound_alignment_bits, c, nb::arg("poses"), bound,
             "As alignment_counts, with bits (H, words) uint64 before the counts.");
  module.def("alignment_residuals", &bound_alignment_residuals, c, nb::arg("pose"),
             "Squared residuals | R p + t - q |^2 of all correspondences under one pose, (N,) float32, working frame:\n"
             "divide by scale ** 2 for the caller's unit. pose: (3, 4) [R | t], working frame.");
  module.def("mismatched_counts", &bound_mismatched_counts, c, nb::arg("pose"), bound, nb::arg("shifts"),
             "Support that a pose gets from mismatched pairs, what chance alone would give: number of j with\n"
             "| R p_j + t - q_k | < bound, k = j + 64 shift, of mismatched_pairs(correspondences, shift) tested.\n"
             "pose: (3, 4), working frame; shifts: (S,) whole numbers > 0. Returns (S,) uint32.");
  module.def(
      "mismatched_pairs",
      [](const SharedCorrespondences& self, std::uint32_t shift) { return mismatched_pairs(*self.rows, shift); }, c,
      nb::arg("shift"), "Number of pairs that mismatched_counts tests for a shift; 0 if it leaves none.");
}

}  // namespace consimd::python
