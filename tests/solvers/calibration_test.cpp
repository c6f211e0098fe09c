// How often a pose is given where there is none: the promise behind Registration::log10_false_poses.
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/hard_problems.hpp>

#include <ostream>
#include <string>
#include <tuple>

#include "outlier_models.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

struct Range {
  double least;
  double most;
};

/// Problems that cost about the same; sizes and noise bounds are spread evenly in their logarithms. The scene is a cube
/// of 200.
struct Batch {
  std::string name;
  Range size;
  Range noise_bound;
  std::uint64_t problems;
  std::uint64_t poses_of_clusters;  ///< most of clustered problems that may have a pose
};

void PrintTo(const Batch& batch, std::ostream* out) { *out << batch.name; }

/// 10 000 problems without any true pose. Success promises less than 10^-3 false poses, so that 10 of them may have
/// one. The parts of clustered problems share 10; in all others random pairings of the same points are what the
/// significance takes chance to be, and hardly one in a hundred thousand may have one.
class Calibration : public ::testing::TestWithParam<std::tuple<synth::OutlierModel, Batch>> {};
INSTANTIATE_TEST_SUITE_P(
    Parts, Calibration,
    ::testing::Combine(::testing::ValuesIn(kOutlierModels),
                       ::testing::Values(Batch{"a_dozen", {5, 25}, {1.0, 6.0}, 800, 4},
                                         Batch{"dozens", {25, 64}, {1.0, 6.0}, 500, 2},
                                         Batch{"a_hundred", {64, 127}, {1.0, 6.0}, 250, 1},
                                         Batch{"hundreds", {128, 500}, {1.0, 6.0}, 150, 2},
                                         // Few pairs agree in length, so that three supporters are rare by chance.
                                         Batch{"hundreds_far_apart", {128, 500}, {0.1, 0.6}, 300, 1})),
    [](const auto& test) {
      return std::string(name_of(std::get<0>(test.param))) + "_" + std::get<1>(test.param).name;
    });

TEST_P(Calibration, PosesByChanceAreAsRareAsPromised) {
  const auto& [model, batch] = GetParam();
  std::uint64_t poses = 0;
  double least = 0.0;
  for (std::uint64_t trial = 0; trial < trials(batch.problems); ++trial) {
    std::mt19937 random(static_cast<std::uint32_t>(trial));
    const auto between = [&](Range range) {
      return range.least * std::pow(range.most / range.least, static_cast<double>(random()) * 0x1p-32);
    };
    synth::HardProblemOptions options{.outlier_ratio = 1.0, .seed = 2024, .trial = trial, .outliers = model};
    options.correspondences = static_cast<std::size_t>(between(batch.size));
    options.clusters = static_cast<std::size_t>(between({5.0, 100.0}));
    options.cluster_sigma = between({0.5, 8.0});
    options.matches_per_point = static_cast<std::size_t>(between({2.0, 6.0}));
    TcfOptions tcf;
    tcf.noise_bound = between(batch.noise_bound);
    tcf.seed = trial;
    const Registration result = register_tcf(synth::hard_problem(options).correspondences(), tcf);
    if (result.has_pose()) ++poses;
    least = std::min(least, result.log10_false_poses);
  }
  const std::uint64_t allowed = model == synth::OutlierModel::clustered ? batch.poses_of_clusters : 0;
  EXPECT_LE(poses, allowed) << "least log10 of false poses " << least;
  RecordProperty("poses", static_cast<int>(poses));
}

}  // namespace
}  // namespace consimd::test
