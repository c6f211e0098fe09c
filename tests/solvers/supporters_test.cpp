// Supporters that tell of different places, against the plain loop over all pairs.
#include "verdict/supporters.hpp"

#include <consimd/synth/hard_problems.hpp>

#include "problems.hpp"
#include "support/points.hpp"
#include "support/pose_candidate.hpp"

namespace consimd::test {
namespace {

detail::Supports by_all_pairs(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound,
                              double radius) {
  const double limit = radius * view.scale() * radius * view.scale();
  detail::Supports result;
  for (std::size_t b = 0; b < result.size(); ++b) {
    const auto rows = detail::pose_inliers(view, pose, detail::kTestedBounds[b] * noise_bound);
    std::vector<detail::Point> spread;
    for (const std::uint32_t row : rows) {
      const detail::Point p = detail::source_point(view, row);
      if (std::ranges::none_of(spread, [&](const auto& q) { return detail::squared_distance(p, q) < limit; })) {
        spread.push_back(p);
      }
    }
    result[b] = {static_cast<double>(rows.size()), static_cast<double>(spread.size())};
  }
  return result;
}

class Supporters : public ::testing::TestWithParam<double> {};

// Radii from what single precision cannot tell from nothing to beyond the scene; at the lattice's own spacing distances
// are ties.
TEST_P(Supporters, AreThoseOfAllPairs) {
  using synth::Scene;
  for (const Scene scene : {Scene::volume, Scene::planar, Scene::linear, Scene::grid}) {
    for (std::uint64_t trial = 0; trial < 3; ++trial) {
      const Problem problem = synth::hard_problem({.correspondences = 700, .trial = trial, .scene = scene});
      const Correspondences correspondences = problem.correspondences();
      const WorkingPose pose = to_working_pose(to_working_frame(problem.T_target_source, correspondences));
      for (const double noise_bound : {0.01, 1.0, 1e3}) {
        const detail::Supports expected = by_all_pairs(correspondences.view(), pose, noise_bound, GetParam());
        const detail::Supports found = detail::supports(correspondences.view(), pose, noise_bound, GetParam());
        for (std::size_t b = 0; b < found.size(); ++b) {
          EXPECT_EQ(found[b].count, expected[b].count)
              << static_cast<int>(scene) << ", bound " << noise_bound << ", " << b;
          EXPECT_EQ(found[b].spread, expected[b].spread)
              << static_cast<int>(scene) << ", bound " << noise_bound << ", " << b;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Radii, Supporters, ::testing::Values(1e-300, 1e-9, 0.01, 0.5, 2.0, 10.0, 45.0, 1e4));

}  // namespace
}  // namespace consimd::test
