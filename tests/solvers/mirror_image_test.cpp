// Mirror images of scenes: no motion is called a success, and the image is named.
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/hard_problems.hpp>

#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <string>

#include "problems.hpp"

namespace consimd::test {
namespace {

using synth::Scene;

class MirrorImage : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Solvers, MirrorImage, ::testing::ValuesIn(kSolvers),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(MirrorImage, HasNoPose) {
  for (const std::size_t size : {4U, 10U, 100U, 400U}) {
    for (const double outlier_ratio : {0.0, 0.5}) {
      for (std::uint64_t trial = 0; trial < trials(5); ++trial) {
        // A rotation fits what lies near a plane: at this noise more of it than chance would give.
        const Problem problem = synth::hard_problem(
            {.correspondences = size, .outlier_ratio = outlier_ratio, .sigma = 1.0, .trial = trial, .mirrored = true});
        for (const std::optional<double> bound : {std::optional(3.0), std::optional<double>()}) {
          const Registration result =
              register_by_name(GetParam(), problem.correspondences(), {.noise_bound = bound, .seed = trial});
          expect_sound(result, problem, result.noise_bound);
          EXPECT_FALSE(result.has_pose()) << size << " rows, trial " << trial << ", " << result.inliers.size();
        }
      }
    }
  }
}

// Ground and walls are about their own image: a motion fits much of such scenes.
TEST_P(MirrorImage, OfSurfacesIsNoSuccessAndIsNamed) {
  std::size_t named = 0;
  std::size_t runs = 0;
  for (const Scene scene : {Scene::planar, Scene::room, Scene::street, Scene::corridor}) {
    for (std::uint64_t trial = 0; trial < trials(12); ++trial) {
      const Problem problem = synth::hard_problem({.correspondences = 400 + 400 * (trial % 4),
                                                   .outlier_ratio = 0.8 + 0.05 * static_cast<double>(trial % 3),
                                                   .sigma = 0.1,
                                                   .half_extent = 20.0,
                                                   .trial = trial,
                                                   .scene = scene,
                                                   .thickness = 2.0,
                                                   .mirrored = true});
      for (const std::optional<double> bound : {std::optional(0.3), std::optional<double>()}) {
        const Registration result =
            register_by_name(GetParam(), problem.correspondences(), {.noise_bound = bound, .seed = trial});
        expect_sound(result, problem, result.noise_bound);
        ++runs;
        if (result.mirrored) ++named;
        EXPECT_NE(result.status, Status::success)
            << "trial " << trial << ": " << result.inliers.size() << " rows within " << result.noise_bound;
      }
    }
  }
  // Of the 96 those are not named whose estimated bound is far too large.
  if (kAllTrials) {
    EXPECT_GE(named, runs - runs / 10);
  }
}

TEST(MirrorImages, IsNamedOfFourRowsToo) {
  for (std::uint64_t trial = 0; trial < 50; ++trial) {
    const Problem problem = synth::hard_problem({.correspondences = 4 + trial % 5,
                                                 .outlier_ratio = 0.0,
                                                 .sigma = 0.005,
                                                 .half_extent = 10.0,
                                                 .trial = trial,
                                                 .mirrored = true});
    const Registration result = register_by_name("tcf", problem.correspondences(), {.noise_bound = 0.04});
    EXPECT_FALSE(result.has_pose());
    // Four points near a plane are their own mirror image.
    EXPECT_TRUE(result.mirrored || problem.size() == 4) << "trial " << trial;
  }
}

TEST(MirrorImages, NeverGivesAReflectionByThePublishedAlgorithm) {
  for (const std::size_t size : {4U, 10U}) {  // its trials are slow where every row agrees with most
    for (std::uint64_t trial = 0; trial < 5; ++trial) {
      const Problem problem = synth::hard_problem(
          {.correspondences = size, .outlier_ratio = 0.0, .sigma = 0.1, .trial = trial, .mirrored = true});
      expect_sound(register_by_name("tcf-published", problem.correspondences(), {.noise_bound = 0.3}), problem, 0.3);
    }
  }
}

}  // namespace
}  // namespace consimd::test
