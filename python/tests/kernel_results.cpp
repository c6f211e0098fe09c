// Runs the kernels on a problem of the noise study and writes what they return, raw numbers, a file each:
// kernel_results FOLDER. kernels_test.py makes the same calls from Python and compares the bytes.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/angle_consistency.hpp>
#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/length_consistency.hpp>
#include <consimd/kernels/length_ratio.hpp>
#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/kernels/three_point_fit.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/synth/noise_study.hpp>

namespace {

using namespace consimd;

constexpr double kBound = 3.0;

class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  template <typename T>
  void write(const std::string& name, std::span<const T> values) const {
    std::ofstream file(folder_ / name, std::ios::binary);
    file.exceptions(std::ios::failbit | std::ios::badbit);
    file.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size_bytes()));
  }
  template <typename T>
  void write(const std::string& name, const std::vector<T>& values) const {
    write(name, std::span<const T>(values));
  }
  /// Row-major.
  void write(const std::string& name, const RigidTransform& pose) const {
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = pose.matrix();
    write(name, std::span<const double>(rows.data(), 16));
  }
  void write(const std::string& name, const RigidMoments& m) const {
    std::vector<double> all{m.weight};
    all.insert(all.end(), std::begin(m.source), std::end(m.source));
    all.insert(all.end(), std::begin(m.target), std::end(m.target));
    all.insert(all.end(), std::begin(m.cross), std::end(m.cross));
    all.insert(all.end(), std::begin(m.source_scatter), std::end(m.source_scatter));
    all.push_back(m.residual);
    write(name, all);
  }

 private:
  std::filesystem::path folder_;
};

void write_consistency(const Correspondences& c, const ResultFolder& out) {
  const CorrespondenceView view = c;
  std::vector<std::uint32_t> seeds;
  std::vector<IndexPair> pairs;
  for (std::uint32_t k = 0; k < 40; ++k) {
    seeds.push_back(7 * k);
    pairs.push_back({k, 300 - k});
  }
  std::vector<std::uint32_t> counts(seeds.size());
  std::vector<std::uint64_t> bits(seeds.size() * view.words());
  length_consistency_bits(view, seeds, 2.0 * kBound, bits, counts);
  out.write("length_bits", bits);
  out.write("length_counts", counts);
  angle_consistency_bits(view, pairs, kBound, bits, counts);
  out.write("angle_bits", bits);
  out.write("angle_counts", counts);

  std::vector<float> costs(seeds.size());
  length_disagreement(view, seeds, 2.0 * kBound, 0.1, costs);
  out.write("length_disagreement", costs);
  std::vector<float> lows(view.words() * kBlock), highs(lows.size());
  scale_intervals(view, 7, kBound, lows, highs);
  out.write("scale_lows", std::span<const float>(lows).first(view.size()));
  out.write("scale_highs", std::span<const float>(highs).first(view.size()));

  ConsistencyMatrix matrix;
  matrix.compute_separated(view, kBound, 20.0);
  out.write("separated_matrix", std::span(matrix.data(), matrix.size() * matrix.words()));
  matrix.compute_ratio(view, kBound, 0.1);
  out.write("ratio_matrix", std::span(matrix.data(), matrix.size() * matrix.words()));
  matrix.compute(view, 2.0 * kBound);
  out.write("matrix", std::span(matrix.data(), matrix.size() * matrix.words()));
  out.write("degrees", matrix.degrees());
  std::vector<float> values(matrix.words() * kBlock);
  for (std::size_t k = 0; k < view.size(); ++k) values[k] = 1.0f / static_cast<float>(k + 1);
  std::vector<float> sums(view.size());
  masked_row_sums(matrix, 0, values, sums);
  out.write("row_sums", sums);
  and_popcount_rows(matrix, matrix.row(5), seeds, counts);
  out.write("common_neighbours", counts);
}

void write_poses(const Correspondences& c, const synth::Problem& problem, const ResultFolder& out) {
  const CorrespondenceView view = c;
  std::vector<IndexTriple> triples;
  triples.reserve(50);
  for (std::uint32_t k = 0; k < 50; ++k) triples.push_back({k, 100 + 3 * k, 350 - 2 * k});
  std::vector<WorkingPose> poses(triples.size());
  three_point_fits(view, triples, poses);
  std::vector<float> rows;
  for (const WorkingPose& pose : poses) {
    for (std::size_t row = 0; row < 3; ++row) {
      rows.insert(rows.end(), pose.rotation + 3 * row, pose.rotation + 3 * row + 3);
      rows.push_back(pose.translation[row]);
    }
  }
  out.write("three_point_fits", rows);

  poses.push_back(to_working_pose(to_working_frame(problem.T_target_source, c)));
  std::vector<PoseSupport> support(poses.size());
  alignment_scores(view, poses, kBound, support);
  std::vector<std::uint32_t> counts;
  std::vector<float> scores;
  for (const PoseSupport& pose : support) {
    counts.push_back(pose.count);
    scores.push_back(pose.score);
  }
  out.write("alignment_counts", counts);
  out.write("alignment_scores", scores);
  std::vector<std::uint64_t> bits(poses.size() * view.words());
  alignment_bits(view, poses, kBound, bits, counts);
  out.write("alignment_bits", bits);

  const WorkingPose& truth = poses.back();
  std::vector<float> squared(view.padded_size());
  alignment_residuals(view, truth, squared);
  out.write("residuals", std::span<const float>(squared).first(view.size()));
  const std::vector<std::uint32_t> shifts{1, 2, 3};
  std::vector<std::uint32_t> mismatched(shifts.size());
  mismatched_counts(view, truth, 50.0, shifts, mismatched);
  out.write("mismatched", mismatched);

  const RigidMoments moments =
      robust_moments(view, truth, {.function = WeightFunction::cauchy, .scale = 1.0, .cutoff = kBound});
  out.write("robust_moments", moments);
  out.write("subset_moments", subset_moments(view, std::span(bits).last(view.words())));
  out.write("fit", to_caller_frame(rigid_fit(moments).pose, c));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: consimd_kernel_results FOLDER\n", stderr);
    return 2;
  }
  try {
    const synth::Problem problem =
        synth::noise_study_problem({.correspondences = 421, .outlier_ratio = 0.7, .seed = 3, .trial = 2});
    const Correspondences c = problem.correspondences();
    const ResultFolder out(argv[1]);
    out.write("source", problem.source);
    out.write("target", problem.target);
    out.write("truth", problem.T_target_source);
    write_consistency(c, out);
    write_poses(c, problem, out);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
