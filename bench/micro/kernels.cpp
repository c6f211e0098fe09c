#include "kernels.hpp"

#include <memory>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/angle_consistency.hpp>
#include <consimd/kernels/length_consistency.hpp>
#include <consimd/kernels/length_ratio.hpp>
#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/kernels/three_point_fit.hpp>

namespace consimd::bench {
namespace {

constexpr std::size_t kAnySize = 100'000;
constexpr double kRatioBound = 0.1;
constexpr std::size_t kMatrixSize = 10'000;  // beyond it the matrix leaves the caches that a registration can count on

std::size_t tests(const Workload& w) { return w.batch() * w.size(); }
std::size_t correspondences(const Workload& w) { return w.size(); }
std::size_t distinct_pairs(const Workload& w) { return w.size() * (w.size() - 1) / 2; }
std::size_t matrix_bits(const Workload& w) { return w.size() * w.size(); }
std::size_t row_bits(const Workload& w) { return w.rows.size() * w.size(); }

Call length_counts(const Workload& w) {
  return [&w](Outcome& out) {
    out.counts.resize(w.batch());
    length_consistency_counts(w.correspondences, w.seeds, w.consistency_bound, out.counts);
  };
}

Call length_bits(const Workload& w) {
  return [&w](Outcome& out) {
    out.counts.resize(w.batch());
    out.bits.resize(w.batch() * w.chosen.size());
    length_consistency_bits(w.correspondences, w.seeds, w.consistency_bound, out.bits, out.counts);
  };
}

Call disagreement(const Workload& w) {
  return [&w](Outcome& out) {
    out.sums.resize(w.batch());
    length_disagreement(w.correspondences, w.seeds, w.noise_bound, kRatioBound, out.sums);
  };
}

/// Lows before highs; what is no number, the padding and the seed itself, left out.
Call intervals(const Workload& w) {
  return [&w](Outcome& out) {
    const std::size_t padded = w.chosen.size() * kBlock;
    out.sums.resize(2 * padded);
    scale_intervals(w.correspondences, w.seeds.front(), w.noise_bound, std::span(out.sums).first(padded),
                    std::span(out.sums).subspan(padded));
    const std::uint32_t seed = w.seeds.front();
    out.sums[seed] = out.sums[padded + seed] = 0.0F;
    for (std::size_t j = w.size(); j < padded; ++j) out.sums[j] = out.sums[padded + j] = 0.0F;
  };
}

Call angle_counts(const Workload& w) {
  return [&w](Outcome& out) {
    out.counts.resize(w.batch());
    angle_consistency_counts(w.correspondences, w.pairs, w.consistency_bound, out.counts);
  };
}

Call angle_bits(const Workload& w) {
  return [&w](Outcome& out) {
    out.counts.resize(w.batch());
    out.bits.resize(w.batch() * w.chosen.size());
    angle_consistency_bits(w.correspondences, w.pairs, w.consistency_bound, out.bits, out.counts);
  };
}

Call pose_counts(const Workload& w) {
  return [&w](Outcome& out) {
    out.counts.resize(w.batch());
    alignment_counts(w.correspondences, w.poses, w.noise_bound, out.counts);
  };
}

Call pose_scores(const Workload& w) {
  return [&w](Outcome& out) {
    out.support.resize(w.batch());
    alignment_scores(w.correspondences, w.poses, w.noise_bound, out.support);
  };
}

Call pose_bits(const Workload& w) {
  return [&w](Outcome& out) {
    out.counts.resize(w.batch());
    out.bits.resize(w.batch() * w.chosen.size());
    alignment_bits(w.correspondences, w.poses, w.noise_bound, out.bits, out.counts);
  };
}

Call moments_weighted(const Workload& w) {
  return [&w](Outcome& out) {
    out.moments = weighted_moments(w.correspondences, {w.weights(), w.correspondences.view().padded_size()});
  };
}

Call moments_subset(const Workload& w) {
  return [&w](Outcome& out) { out.moments = subset_moments(w.correspondences, w.chosen); };
}

template <WeightFunction kFunction>
Call moments_robust(const Workload& w) {
  return [&w](Outcome& out) {
    const RobustWeight weight{
        .function = kFunction, .scale = w.noise_bound / 3.0, .cutoff = 3.0 * w.noise_bound, .odds = 0.01};
    out.moments = robust_moments(w.correspondences, w.poses.front(), weight);
  };
}

Call minimal_fits(const Workload& w) {
  return [&w](Outcome& out) {
    out.poses.resize(w.triples.size());
    three_point_fits(w.correspondences, w.triples, out.poses);
  };
}

Call matrix(const Workload& w) {
  return [&w](Outcome& out) {
    out.matrix.compute(w.correspondences, w.consistency_bound);
    out.counts.assign(out.matrix.degrees().begin(), out.matrix.degrees().end());
  };
}

Call separated_matrix(const Workload& w) {
  return [&w](Outcome& out) {
    out.matrix.compute_separated(w.correspondences, w.consistency_bound, w.noise_bound);
    out.counts.assign(out.matrix.degrees().begin(), out.matrix.degrees().end());
  };
}

Call ratio_matrix(const Workload& w) {
  return [&w](Outcome& out) {
    out.matrix.compute_ratio(w.correspondences, w.consistency_bound, kRatioBound);
    out.counts.assign(out.matrix.degrees().begin(), out.matrix.degrees().end());
  };
}

Call matrix_rows(const Workload& w) {
  const auto graph = std::make_shared<ConsistencyMatrix>();
  graph->compute(w.correspondences, w.consistency_bound);
  return [&w, graph](Outcome& out) {
    out.counts.resize(w.rows.size());
    and_popcount_rows(*graph, w.chosen, w.rows, out.counts);
  };
}

Call masked_sums(const Workload& w) {
  const auto graph = std::make_shared<ConsistencyMatrix>();
  graph->compute(w.correspondences, w.consistency_bound);
  return [&w, graph](Outcome& out) {
    out.sums.resize(w.size());
    masked_row_sums(*graph, 0, {w.weights(), graph->words() * kBlock}, out.sums);
  };
}

}  // namespace

bool takes_batches(const Kernel& kernel) { return kernel.items == tests; }

const std::vector<Kernel>& kernels() {
  static const std::vector<Kernel> list{
      {"length_consistency_counts", "pairs", tests, kAnySize, length_counts},
      {"length_consistency_bits", "pairs", tests, kAnySize, length_bits},
      {"length_disagreement", "pairs", tests, kAnySize, disagreement},
      {"scale_intervals", "pairs", correspondences, kAnySize, intervals},
      {"angle_consistency_counts", "triples", tests, kAnySize, angle_counts},
      {"angle_consistency_bits", "triples", tests, kAnySize, angle_bits},
      {"alignment_counts", "residuals", tests, kAnySize, pose_counts},
      {"alignment_scores", "residuals", tests, kAnySize, pose_scores},
      {"alignment_bits", "residuals", tests, kAnySize, pose_bits},
      {"weighted_moments", "correspondences", correspondences, kAnySize, moments_weighted},
      {"subset_moments", "correspondences", correspondences, kAnySize, moments_subset},
      {"robust_moments_cauchy", "correspondences", correspondences, kAnySize, moments_robust<WeightFunction::cauchy>},
      {"robust_moments_mixture", "correspondences", correspondences, kAnySize,
       moments_robust<WeightFunction::student_uniform>},
      {"three_point_fits", "fits", correspondences, kAnySize, minimal_fits},
      {"consistency_matrix", "distinct pairs", distinct_pairs, kMatrixSize, matrix},
      {"separated_matrix", "distinct pairs", distinct_pairs, kMatrixSize, separated_matrix},
      {"ratio_matrix", "distinct pairs", distinct_pairs, kMatrixSize, ratio_matrix},
      {"and_popcount_rows", "bits", row_bits, kMatrixSize, matrix_rows},
      {"masked_row_sums", "bits", matrix_bits, kMatrixSize, masked_sums},
  };
  return list;
}

}  // namespace consimd::bench
