#include <algorithm>
#include <memory>

#include "kernels.hpp"

namespace consimd::bench {
namespace {

/// counts[h] = count(h) for a batch of hypotheses.
template <typename Count>
void fill_counts(Outcome& out, std::size_t batch, const Count& count) {
  out.counts.resize(batch);
  for (std::size_t h = 0; h < batch; ++h) out.counts[h] = count(h);
}

/// The same for baselines that store the set, as bytes or row numbers, in `set`; its size or sum is the count.
template <typename Collect>
Call eigen_sets(const Workload& w, Collect collect) {
  return [&w, collect, set = std::vector<std::uint32_t>()](Outcome& out) mutable {
    fill_counts(out, w.batch(), [&](std::size_t h) {
      collect(h, &set);
      return static_cast<std::uint32_t>(set.size());
    });
  };
}

template <typename Mark>
Call loop_sets(const Workload& w, Mark mark) {
  return [&w, mark, passes = std::vector<std::uint8_t>(w.size())](Outcome& out) mutable {
    fill_counts(out, w.batch(), [&](std::size_t h) {
      mark(h, passes.data());
      return static_cast<std::uint32_t>(std::count(passes.begin(), passes.end(), std::uint8_t{1}));
    });
  };
}

/// From the caller's frame to the working frame.
RigidMoments working_moments(const EigenMoments& m, const Correspondences& frame) {
  const Eigen::Map<const Eigen::Vector3d> p(frame.source_centroid().data()), q(frame.target_centroid().data());
  const double scale = frame.scale();
  const Eigen::Vector3d source = scale * (m.source - m.weight * p);
  const Eigen::Vector3d target = scale * (m.target - m.weight * q);
  const Eigen::Matrix3d cross =
      scale * scale * (m.cross - m.target * p.transpose() - q * m.source.transpose() + m.weight * q * p.transpose());
  RigidMoments moments{};
  moments.weight = m.weight;
  for (int a = 0; a < 3; ++a) {
    moments.source[a] = source[a];
    moments.target[a] = target[a];
    for (int b = 0; b < 3; ++b) moments.cross[3 * a + b] = cross(a, b);
  }
  return moments;
}

RigidMoments working_moments(const LoopMoments& m) {
  RigidMoments moments{};
  moments.weight = static_cast<double>(m.weight);
  std::copy(std::begin(m.source), std::end(m.source), moments.source);
  std::copy(std::begin(m.target), std::end(m.target), moments.target);
  std::copy(std::begin(m.cross), std::end(m.cross), moments.cross);
  return moments;
}

WorkingPose working_pose(const EigenPose& pose, const Correspondences& frame) {
  const Eigen::Map<const Eigen::Vector3d> p(frame.source_centroid().data()), q(frame.target_centroid().data());
  const Eigen::Vector3d t = frame.scale() * (pose.R * p + pose.t - q);
  WorkingPose working{};
  for (int a = 0; a < 3; ++a) {
    working.translation[a] = static_cast<float>(t[a]);
    for (int b = 0; b < 3; ++b) working.rotation[3 * a + b] = static_cast<float>(pose.R(a, b));
  }
  return working;
}

Call eigen_fits(const Workload& w) {
  return [&w](Outcome& out) {
    out.poses.resize(w.triples.size());
    for (std::size_t h = 0; h < w.triples.size(); ++h) {
      const IndexTriple& triple = w.triples[h];
      const std::uint32_t rows[3] = {triple.first, triple.second, triple.third};
      out.poses[h] = working_pose(eigen::three_point_fit(w.eigen, rows), w.correspondences);
    }
  };
}

Call eigen_matrix(const Workload& w) {
  return [&w, matrix = std::vector<char>()](Outcome& out) mutable {
    eigen::consistency_matrix(w.eigen, w.consistency_bound, &matrix);
    out.counts.resize(w.size());
    for (std::size_t j = 0; j < w.size(); ++j) {
      out.counts[j] = eigen::common_count(&matrix[j * w.size()], &matrix[j * w.size()], w.size());
    }
  };
}

/// All pairs, each twice: the loop that vectorises.
Call loop_matrix(const Workload& w) {
  return [&w, matrix = std::vector<std::uint8_t>(w.size() * w.size())](Outcome& out) mutable {
    out.counts.resize(w.size());
    for (std::size_t j = 0; j < w.size(); ++j) {
      std::uint8_t* const row = matrix.data() + j * w.size();
      loop::length_set(w.loop, static_cast<std::uint32_t>(j), w.loop_consistency_bound, row);
      out.counts[j] = static_cast<std::uint32_t>(std::count(row, row + w.size(), std::uint8_t{1}));
    }
  };
}

Call eigen_matrix_rows(const Workload& w) {
  std::vector<char> matrix;
  eigen::consistency_matrix(w.eigen, w.consistency_bound, &matrix);
  std::vector<char> set(w.size());
  for (const std::uint32_t row : w.rows) set[row] = 1;
  return [&w, matrix, set](Outcome& out) {
    out.counts.resize(w.rows.size());
    for (std::size_t r = 0; r < w.rows.size(); ++r) {
      out.counts[r] = eigen::common_count(&matrix[w.rows[r] * w.size()], set.data(), w.size());
    }
  };
}

Call loop_matrix_rows(const Workload& w) {
  const auto matrix = std::make_shared<ConsistencyMatrix>();
  matrix->compute(w.correspondences, w.consistency_bound);
  return [&w, matrix](Outcome& out) {
    out.counts.resize(w.rows.size());
    for (std::size_t r = 0; r < w.rows.size(); ++r) {
      out.counts[r] = loop::common_count(matrix->row(w.rows[r]).data(), w.chosen.data(), matrix->words());
    }
  };
}

Call loop_row_sums(const Workload& w) {
  const auto matrix = std::make_shared<ConsistencyMatrix>();
  matrix->compute(w.correspondences, w.consistency_bound);
  return [&w, matrix](Outcome& out) {
    out.sums.resize(w.size());
    for (std::size_t r = 0; r < w.size(); ++r) {
      out.sums[r] = loop::masked_sum(matrix->row(r).data(), matrix->words(), w.weights());
    }
  };
}

// The remaining baselines are one call for each hypothesis.

Call eigen_length_counts(const Workload& w) {
  return [&w](Outcome& out) {
    fill_counts(out, w.batch(),
                [&](std::size_t h) { return eigen::length_count(w.eigen, w.seeds[h], w.consistency_bound); });
  };
}
template <auto kCount>
Call loop_length_counts(const Workload& w) {
  return [&w](Outcome& out) {
    fill_counts(out, w.batch(), [&](std::size_t h) { return kCount(w.loop, w.seeds[h], w.loop_consistency_bound); });
  };
}
Call eigen_length_sets(const Workload& w) {
  return eigen_sets(
      w, [&w](std::size_t h, auto* set) { eigen::length_set(w.eigen, w.seeds[h], w.consistency_bound, set); });
}
Call loop_length_sets(const Workload& w) {
  return loop_sets(w, [&w](std::size_t h, std::uint8_t* passes) {
    loop::length_set(w.loop, w.seeds[h], w.loop_consistency_bound, passes);
  });
}

Call eigen_angle_counts(const Workload& w) {
  return [&w](Outcome& out) {
    fill_counts(out, w.batch(), [&](std::size_t h) {
      return eigen::angle_count(w.eigen, w.pairs[h].first, w.pairs[h].second, w.consistency_bound);
    });
  };
}
template <auto kCount>
Call loop_angle_counts(const Workload& w) {
  return [&w](Outcome& out) {
    fill_counts(out, w.batch(), [&](std::size_t h) {
      return kCount(w.loop, w.pairs[h].first, w.pairs[h].second, w.loop_consistency_bound);
    });
  };
}
Call eigen_angle_sets(const Workload& w) {
  return eigen_sets(w, [&w](std::size_t h, auto* set) {
    eigen::angle_set(w.eigen, w.pairs[h].first, w.pairs[h].second, w.consistency_bound, set);
  });
}
Call loop_angle_sets(const Workload& w) {
  return loop_sets(w, [&w](std::size_t h, std::uint8_t* passes) {
    loop::angle_set(w.loop, w.pairs[h].first, w.pairs[h].second, w.loop_consistency_bound, passes);
  });
}

Call eigen_alignment_counts(const Workload& w) {
  return [&w](Outcome& out) {
    fill_counts(out, w.batch(),
                [&](std::size_t h) { return eigen::alignment_count(w.eigen, w.eigen_poses[h], w.noise_bound); });
  };
}
template <auto kCount>
Call loop_alignment_counts(const Workload& w) {
  return [&w](Outcome& out) {
    fill_counts(out, w.batch(), [&](std::size_t h) { return kCount(w.loop, w.loop_poses[h], w.loop_noise_bound); });
  };
}
Call eigen_alignment_sets(const Workload& w) {
  return eigen_sets(
      w, [&w](std::size_t h, auto* set) { eigen::alignment_set(w.eigen, w.eigen_poses[h], w.noise_bound, set); });
}
Call loop_alignment_sets(const Workload& w) {
  return loop_sets(w, [&w](std::size_t h, std::uint8_t* passes) {
    loop::alignment_set(w.loop, w.loop_poses[h], w.loop_noise_bound, passes);
  });
}
Call eigen_alignment_scores(const Workload& w) {
  return [&w](Outcome& out) {
    out.support.resize(w.batch());
    for (std::size_t h = 0; h < w.batch(); ++h) {
      out.support[h].score = static_cast<float>(eigen::alignment_score(w.eigen, w.eigen_poses[h], w.noise_bound));
    }
  };
}
Call loop_alignment_scores(const Workload& w) {
  return [&w](Outcome& out) {
    out.support.resize(w.batch());
    for (std::size_t h = 0; h < w.batch(); ++h) {
      out.support[h].score = loop::alignment_score(w.loop, w.loop_poses[h], w.loop_noise_bound);
    }
  };
}

Call eigen_weighted(const Workload& w) {
  return [&w](Outcome& out) {
    out.moments = working_moments(eigen::weighted_moments(w.eigen, w.weights()), w.correspondences);
  };
}
Call loop_weighted(const Workload& w) {
  return [&w](Outcome& out) { out.moments = working_moments(loop::weighted_moments(w.loop, w.weights())); };
}
Call eigen_subset(const Workload& w) {
  return
      [&w](Outcome& out) { out.moments = working_moments(eigen::subset_moments(w.eigen, w.rows), w.correspondences); };
}
Call eigen_cauchy(const Workload& w) {
  return [&w](Outcome& out) {
    const EigenMoments moments =
        eigen::cauchy_moments(w.eigen, w.eigen_poses.front(), w.noise_bound / 3.0, 3.0 * w.noise_bound);
    out.moments = working_moments(moments, w.correspondences);
  };
}
Call loop_cauchy(const Workload& w) {
  return [&w](Outcome& out) {
    out.moments = working_moments(
        loop::cauchy_moments(w.loop, w.loop_poses.front(), w.loop_noise_bound / 3.0f, 3.0f * w.loop_noise_bound));
  };
}

}  // namespace

const std::vector<Baseline>& baselines() {
  static const std::vector<Baseline> list{
      {"loop", "length_consistency_counts", loop_length_counts<loop::length_count>},
      {"textbook", "length_consistency_counts", loop_length_counts<textbook::length_count>},
      {"eigen", "length_consistency_counts", eigen_length_counts},
      {"loop", "length_consistency_bits", loop_length_sets},
      {"eigen", "length_consistency_bits", eigen_length_sets},
      {"loop", "angle_consistency_counts", loop_angle_counts<loop::angle_count>},
      {"textbook", "angle_consistency_counts", loop_angle_counts<textbook::angle_count>},
      {"eigen", "angle_consistency_counts", eigen_angle_counts},
      {"loop", "angle_consistency_bits", loop_angle_sets},
      {"eigen", "angle_consistency_bits", eigen_angle_sets},
      {"loop", "alignment_counts", loop_alignment_counts<loop::alignment_count>},
      {"textbook", "alignment_counts", loop_alignment_counts<textbook::alignment_count>},
      {"eigen", "alignment_counts", eigen_alignment_counts},
      {"loop", "alignment_scores", loop_alignment_scores},
      {"eigen", "alignment_scores", eigen_alignment_scores},
      {"loop", "alignment_bits", loop_alignment_sets},
      {"eigen", "alignment_bits", eigen_alignment_sets},
      {"loop", "weighted_moments", loop_weighted},
      {"eigen", "weighted_moments", eigen_weighted},
      {"eigen", "subset_moments", eigen_subset},
      {"loop", "robust_moments_cauchy", loop_cauchy},
      {"eigen", "robust_moments_cauchy", eigen_cauchy},
      {"eigen", "three_point_fits", eigen_fits},
      {"loop", "consistency_matrix", loop_matrix},
      {"eigen", "consistency_matrix", eigen_matrix},
      {"loop", "and_popcount_rows", loop_matrix_rows},
      {"eigen", "and_popcount_rows", eigen_matrix_rows},
      {"loop", "masked_row_sums", loop_row_sums},
  };
  return list;
}

}  // namespace consimd::bench
