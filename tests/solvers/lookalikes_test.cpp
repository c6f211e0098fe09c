// Problems without a pose whose matches keep what a descriptor sees: how often one is called a success.
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <array>
#include <cstddef>
#include <ostream>
#include <string>

#include "problems.hpp"

namespace consimd::test {
namespace {

struct Kind {
  const char* name;
  synth::Scene scene;
  double half_extent, sigma;
  std::size_t parts;
};

void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

class Lookalikes : public ::testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Lookalikes,
                         ::testing::Values(Kind{"kept_range", synth::Scene::volume, 40.0, 0.3, 1},
                                           Kind{"planes", synth::Scene::planar, 50.0, 0.3, 1},
                                           Kind{"rings", synth::Scene::rings, 90.0, 0.15, 32},
                                           Kind{"poles", synth::Scene::poles, 40.0, 0.15, 20},
                                           Kind{"lines", synth::Scene::lines, 30.0, 0.15, 15},
                                           Kind{"corridor", synth::Scene::corridor, 30.0, 0.1, 1},
                                           Kind{"room", synth::Scene::room, 5.0, 0.08, 1},
                                           Kind{"facade", synth::Scene::facade, 25.0, 0.07, 16},
                                           Kind{"grid", synth::Scene::grid, 9.0, 0.1, 6}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(Lookalikes, AreSeldomASuccess) {
  // With two seeds of the generator, tcf calls 7 of 2000 facades of these sizes a success, and fewer of every other
  // kind (bench/false_poses). Three or more of 40 are then by chance alone in one of two thousand choices of the seed.
  constexpr std::uint64_t kTrials = 10;
  constexpr std::array<std::size_t, 4> kSizes{100, 300, 1000, 3000};
  constexpr std::uint64_t kMost = 2;
  std::uint64_t successes = 0;
  for (const std::size_t rows : kSizes) {
    for (std::uint64_t trial = 0; trial < trials(kTrials); ++trial) {
      const Problem problem = synth::hard_problem({.correspondences = rows,
                                                   .outlier_ratio = 1.0,
                                                   .sigma = GetParam().sigma,
                                                   .half_extent = GetParam().half_extent,
                                                   .seed = 90,
                                                   .trial = trial,
                                                   .scene = GetParam().scene,
                                                   .parts = GetParam().parts,
                                                   .outliers = synth::OutlierModel::alike});
      const double noise_bound = synth::noise_study_bound(problem.sigma);
      const Registration result =
          register_tcf(problem.correspondences(), {.noise_bound = noise_bound, .seed = trial + 1});
      expect_sound(result, problem, noise_bound);
      if (result.status == Status::success) ++successes;
    }
  }
  if (!kAllTrials) return;
  EXPECT_LE(successes, kMost);
}

}  // namespace
}  // namespace consimd::test
