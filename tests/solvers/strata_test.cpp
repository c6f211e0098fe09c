// Structure that matchers keep: however a pose's hits are found, they are the same.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/synth/hard_problems.hpp>

#include "support/points.hpp"
#include "support/repeated_points.hpp"
#include "verdict/background.hpp"
#include "verdict/kept_structure.hpp"
#include "verdict/reached_targets.hpp"
#include "verdict/strata.hpp"

namespace consimd::detail {
namespace {

Correspondences rows_of(synth::Scene scene, synth::OutlierModel outliers) {
  synth::HardProblemOptions options;
  options.correspondences = 700;
  options.outlier_ratio = 0.9;
  options.sigma = 0.1;
  options.half_extent = 10.0;
  options.scene = scene;
  options.outliers = outliers;
  options.parts = 8;
  return synth::hard_problem(options).correspondences();
}

struct Kind {
  synth::Scene scene;
  synth::OutlierModel outliers;
};
constexpr Kind kKinds[] = {{synth::Scene::volume, synth::OutlierModel::uniform},
                           {synth::Scene::planar, synth::OutlierModel::alike},
                           {synth::Scene::volume, synth::OutlierModel::clustered},
                           {synth::Scene::room, synth::OutlierModel::many_to_many}};

TEST(ReachedTargets, AreAllPairsWithinTheBound) {
  for (const auto& [scene, outliers] : kKinds) {
    const Correspondences correspondences = rows_of(scene, outliers);
    const CorrespondenceView view = correspondences.view();
    const WorkingPose pose = to_working_pose(RigidTransform::Identity());
    for (const double bound : {0.05, 0.3, 2.0, 100.0}) {
      const auto limit = static_cast<float>(bound * view.scale() * bound * view.scale());
      std::size_t expected = 0;
      for (std::size_t i = 0; i < view.size(); ++i) {
        for (std::size_t j = 0; j < view.size(); ++j) {
          expected += squared_distance(moved(pose, source_point(view, i)), target_point(view, j)) < limit ? 1U : 0U;
        }
      }
      const std::vector<ReachedTarget> reached = reached_targets(view, pose, bound);
      EXPECT_EQ(reached.size(), expected) << "bound " << bound;
      for (const ReachedTarget& r : reached) {
        ASSERT_EQ(r.squared,
                  squared_distance(moved(pose, source_point(view, r.source_row)), target_point(view, r.target_row)));
      }
    }
  }
}

TEST(Strata, CountTheSameHitsFromWhatIsReached) {
  for (const auto& [scene, outliers] : kKinds) {
    const Correspondences correspondences = rows_of(scene, outliers);
    const CorrespondenceView view = correspondences.view();
    const WorkingPose pose = to_working_pose(RigidTransform::Identity());
    const KeptStructure kept(correspondences);
    for (const double bound : {0.3, 3.0}) {
      const MatchedPoints matched(view, pose, bound);
      const std::vector<ReachedTarget> reached = reached_targets(view, pose, bound);
      double all = 0.0;
      for (std::size_t kind = 0; kind < kept.kinds(); ++kind) {
        for (const Strata& strata : kept.strata(kind, bound)) {
          const PairingHits by_rows = strata.support(pose, bound, matched);
          const PairingHits by_cells = strata.support(reached, bound, matched);
          EXPECT_EQ(by_rows.trials, by_cells.trials);
          for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
            EXPECT_NEAR(by_rows.hits[b], by_cells.hits[b], 1e-9 * by_rows.hits[b]);
          }
          all += by_rows.hits.front();
        }
      }
      EXPECT_TRUE(bound < 1.0 || all > 0.0);
    }
  }
}

TEST(Background, TellsOfAPoseTheSameAgainAndNoLessThanEnough) {
  const Correspondences correspondences = rows_of(synth::Scene::planar, synth::OutlierModel::alike);
  const WorkingPose pose = to_working_pose(RigidTransform::Identity());
  const auto kept = std::make_shared<const KeptStructure>(correspondences);
  for (const double bound : {0.3, 1.0, 3.0}) {
    const double value = Background(correspondences, bound).log_false_poses(pose, 1e9);
    const Background shared(correspondences, bound, kept);
    for (const double enough : {-50.0, -5.0, 0.0, 1e9}) {
      const double told = shared.log_false_poses(pose, enough);
      if (value < enough) {
        EXPECT_EQ(told, value);
      } else {
        EXPECT_GE(told, enough);
        EXPECT_LE(told, value);
      }
      EXPECT_EQ(shared.log_false_poses(pose, enough), told);
    }
    EXPECT_EQ(shared.log_false_poses(pose, 1e9), value);
  }
}

}  // namespace
}  // namespace consimd::detail
