#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/metrics.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <consimd/synth/noise_study.hpp>

namespace consimd::synth {
namespace {

using Point = std::array<double, 3>;

constexpr std::array kOutlierModels{OutlierModel::uniform,     OutlierModel::permuted,     OutlierModel::clustered,
                                    OutlierModel::one_to_many, OutlierModel::many_to_many, OutlierModel::alike};
constexpr std::array kScenes{Scene::volume, Scene::planar,   Scene::linear, Scene::rings,  Scene::poles,
                             Scene::lines,  Scene::corridor, Scene::room,   Scene::facade, Scene::grid};

Point point(const std::vector<double>& cloud, std::size_t k) {
  return {cloud[3 * k], cloud[3 * k + 1], cloud[3 * k + 2]};
}

Eigen::Vector3d vector(const std::vector<double>& cloud, std::size_t k) { return Eigen::Vector3d(&cloud[3 * k]); }

Eigen::Vector3d residual(const Problem& problem, std::size_t k) {
  return vector(problem.target, k) - problem.T_target_source * vector(problem.source, k);
}

std::size_t inlier_count(const Problem& problem) {
  return static_cast<std::size_t>(std::ranges::count(problem.is_inlier, 1));
}

/// The same rows with the labels turned round: what the metrics call inliers are then the outliers.
Problem outliers_as_inliers(Problem problem) {
  for (std::uint8_t& label : problem.is_inlier) label = label == 0 ? 1 : 0;
  return problem;
}

double residual_of_best_motion(const Problem& problem) { return rmse_true_inliers(problem, oracle(problem)); }

/// Standard deviations of a cloud along its principal axes, ascending.
Eigen::Vector3d principal_deviations(const std::vector<double>& cloud) {
  const Eigen::Map<const Eigen::Matrix3Xd> points(cloud.data(), 3, static_cast<Eigen::Index>(cloud.size() / 3));
  const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  const Eigen::Matrix3d covariance = centred * centred.transpose() / static_cast<double>(points.cols());
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues().cwiseMax(0.0).cwiseSqrt();
}

TEST(HardProblem, DefaultsAreTheNoiseStudy) {
  const Problem hard = hard_problem({.outlier_ratio = 0.95, .sigma = 2.0, .seed = 9, .trial = 3});
  const Problem study = noise_study_problem({.outlier_ratio = 0.95, .sigma = 2.0, .seed = 9, .trial = 3});
  EXPECT_EQ(hard.source, study.source);
  EXPECT_EQ(hard.target, study.target);
  EXPECT_EQ(hard.is_inlier, study.is_inlier);
}

TEST(HardProblem, EveryOutlierModelKeepsCountsAndInliers) {
  for (const OutlierModel outliers : kOutlierModels) {
    for (const std::size_t n : {3u, 10u, 1000u}) {
      for (const double ratio : {0.0, 0.4, 0.7, 0.95, 1.0}) {
        const HardProblemOptions options{
            .correspondences = n, .outlier_ratio = ratio, .sigma = 0.01, .seed = 2, .outliers = outliers};
        const auto inliers = static_cast<std::size_t>(std::floor(static_cast<double>(n) * (1.0 - ratio) + 0.5));
        if (outliers == OutlierModel::permuted && n - inliers == 1) {
          EXPECT_THROW(static_cast<void>(hard_problem(options)), std::invalid_argument);
          continue;
        }
        const Problem problem = hard_problem(options);
        EXPECT_EQ(problem.target, hard_problem(options).target);
        ASSERT_EQ(problem.size(), n);
        EXPECT_EQ(inlier_count(problem), inliers);
        for (std::size_t k = 0; k < n; ++k) {
          // A tenth of a metre about the true target: a random point falls there with chance 5e-10 in the cube.
          EXPECT_EQ(residual(problem, k).norm() < 0.1, problem.is_inlier[k] == 1);
        }
      }
    }
  }
}

TEST(HardProblem, ScenesOfRandomPlacesHaveAsManyPartsAsAskedFor) {
  // Points of a vertical pole: their differences are parallel if they are on the same one.
  const Problem one = hard_problem({.outlier_ratio = 0.0, .sigma = 0.0, .scene = Scene::poles, .parts = 1});
  EXPECT_NEAR(principal_deviations(one.source)[2], 100.0 / 6.0 / std::sqrt(12.0), 0.3);
  for (const Scene scene : {Scene::poles, Scene::lines}) {
    EXPECT_LT(principal_deviations(hard_problem({.outlier_ratio = 0.0, .scene = scene, .parts = 1}).source)[1], 1e-6);
    EXPECT_GT(principal_deviations(hard_problem({.outlier_ratio = 0.0, .scene = scene, .parts = 2}).source)[1], 0.1);
  }
}

TEST(HardProblem, RangeDependentNoiseHasItsDeviationInEveryScene) {
  for (const Scene scene : kScenes) {
    const Problem problem = hard_problem({.correspondences = 40000,
                                          .outlier_ratio = 0.0,
                                          .sigma = 0.5,
                                          .scene = scene,
                                          .noise = NoiseModel::range_dependent});
    double squares = 0.0;
    for (std::size_t k = 0; k < problem.size(); ++k) squares += residual(problem, k).squaredNorm();
    EXPECT_NEAR(std::sqrt(squares / 3.0 / 40000.0), 0.5, 0.01) << static_cast<int>(scene);
  }
}

TEST(HardProblem, PermutedOutliersUseEveryTargetOnce) {
  const Problem problem =
      hard_problem({.correspondences = 500, .outlier_ratio = 0.8, .sigma = 0.0, .outliers = OutlierModel::permuted});
  std::set<Point> targets;
  std::size_t moved_back = 0;  // outliers whose source, moved, is the target of another row
  std::vector<Eigen::Vector3d> all;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    targets.insert(point(problem.target, k));
    all.push_back(vector(problem.target, k));
  }
  EXPECT_EQ(targets.size(), 500u);
  for (std::size_t k = 0; k < problem.size(); ++k) {
    if (problem.is_inlier[k] == 1) continue;
    const Eigen::Vector3d moved = problem.T_target_source * vector(problem.source, k);
    moved_back += std::ranges::any_of(all, [&](const Eigen::Vector3d& q) { return (q - moved).norm() < 1e-9; });
  }
  EXPECT_EQ(moved_back, 400u);
}

TEST(HardProblem, ManyToManyRespectsTheNumberOfMatches) {
  for (const std::size_t matches : {2u, 3u, 5u}) {
    for (const double ratio : {0.3, 0.6, 0.95, 1.0}) {
      const Problem problem = hard_problem({.correspondences = 1000,
                                            .outlier_ratio = ratio,
                                            .outliers = OutlierModel::many_to_many,
                                            .matches_per_point = matches});
      std::map<Point, std::size_t> of_source, of_target;
      std::set<std::pair<Point, Point>> pairs;
      for (std::size_t k = 0; k < problem.size(); ++k) {
        ++of_source[point(problem.source, k)];
        ++of_target[point(problem.target, k)];
        pairs.emplace(point(problem.source, k), point(problem.target, k));
      }
      EXPECT_EQ(pairs.size(), 1000u);
      for (const auto& [source, degree] : of_source) EXPECT_LE(degree, matches);
      for (const auto& [target, degree] : of_target) EXPECT_LE(degree, matches);
      if (ratio >= 0.95) {  // few features have a true match, and all have every wrong one that is allowed
        const double average = 1000.0 / static_cast<double>(of_source.size());
        EXPECT_GT(average, static_cast<double>(matches) - 1.1);
      }
    }
  }
}

TEST(HardProblem, OneToManySharesSources) {
  const Problem problem = hard_problem(
      {.correspondences = 900, .outlier_ratio = 1.0, .outliers = OutlierModel::one_to_many, .matches_per_point = 30});
  std::map<Point, std::set<Point>> targets;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    targets[point(problem.source, k)].insert(point(problem.target, k));
  }
  EXPECT_EQ(targets.size(), 30u);
  for (const auto& [source, matched] : targets) EXPECT_EQ(matched.size(), 30u);
}

TEST(HardProblem, ClusteredOutliersLieInClustersOfBothClouds) {
  const Problem problem = hard_problem({.correspondences = 600,
                                        .outlier_ratio = 1.0,
                                        .outliers = OutlierModel::clustered,
                                        .clusters = 3,
                                        .cluster_sigma = 0.5});
  // Rows of one cluster are near one another in both clouds; a row starts a cluster if no earlier one is near.
  std::vector<std::size_t> starts;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const bool known = std::ranges::any_of(starts, [&](std::size_t start) {
      return (vector(problem.source, k) - vector(problem.source, start)).norm() < 6.0 &&
             (vector(problem.target, k) - vector(problem.target, start)).norm() < 6.0;
    });
    if (!known) starts.push_back(k);
  }
  EXPECT_EQ(starts.size(), 3u);
  EXPECT_GT(residual_of_best_motion(outliers_as_inliers(problem)), 0.5);
}

TEST(HardProblem, DecoyFollowsASecondRigidMotion) {
  for (const OutlierModel outliers : kOutlierModels) {
    // All outliers are the decoy's: 200 rows of 400, as many as inliers.
    const Problem problem = hard_problem(
        {.correspondences = 400, .outlier_ratio = 0.5, .sigma = 0.1, .outliers = outliers, .decoy_share = 1.0});
    const Problem decoy = outliers_as_inliers(problem);
    ASSERT_EQ(inlier_count(decoy), 200u);
    EXPECT_NEAR(residual_of_best_motion(decoy), 0.1 * std::sqrt(3.0), 0.02);
    EXPECT_GT(rotation_error_deg(oracle(decoy), problem.T_target_source), 1.0);
  }
  const auto more_than_outliers = HardProblemOptions{.correspondences = 100, .outlier_ratio = 0.5, .decoy_share = 1.1};
  EXPECT_THROW(static_cast<void>(hard_problem(more_than_outliers)), std::invalid_argument);
}

TEST(HardProblem, DecoyTakesItsShareOfTheInliersNumber) {
  const HardProblemOptions options{.correspondences = 1000, .outlier_ratio = 0.9, .decoy_share = 0.5};
  HardProblemOptions without = options;
  without.decoy_share = 0.0;
  const Problem problem = hard_problem(options), plain = hard_problem(without);
  EXPECT_EQ(inlier_count(problem), 100u);
  EXPECT_EQ(problem.is_inlier, plain.is_inlier);
  // The points are the same with and without a decoy, and the inliers' targets: only the outliers' differ.
  EXPECT_EQ(problem.source, plain.source);
  for (std::size_t k = 0; k < problem.size(); ++k) {
    if (problem.is_inlier[k] == 1) {
      EXPECT_EQ(point(problem.target, k), point(plain.target, k));
    }
  }
}

TEST(HardProblem, DecoysFollowTheMotionThatIsReported) {
  const Problem problem = hard_problem({.correspondences = 300,
                                        .outlier_ratio = 0.5,
                                        .sigma = 0.01,
                                        .decoy_share = 1.0,
                                        .source_offset = {5e3, -3e2, 120.0},
                                        .target_offset = {-1e2, 4e3, 0.0},
                                        .units_per_metre = 1000.0});
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const Eigen::Vector3d by_decoy = problem.decoy_T_target_source * vector(problem.source, k);
    EXPECT_EQ((vector(problem.target, k) - by_decoy).norm() < 100.0, problem.is_inlier[k] == 0);
  }
}

TEST(HardProblem, SymmetricScenesAreTheirOwnImage) {
  for (const Scene scene : {Scene::volume, Scene::planar, Scene::linear}) {
    for (const double share : {0.0, 0.6, 1.0}) {
      const Problem problem = hard_problem({.correspondences = 200,
                                            .outlier_ratio = 0.5,
                                            .sigma = 0.0,
                                            .scene = scene,
                                            .thickness = 20.0,
                                            .decoy_share = share,
                                            .symmetric = true});
      const RigidTransform turn = problem.T_target_source.inverse() * problem.decoy_T_target_source;
      EXPECT_NEAR(rotation_error_deg(turn, RigidTransform::Identity()), 180.0, 1e-9);
      EXPECT_LT(turn.translation().norm(), 1e-9);
      std::size_t images = 0, decoys = 0;
      for (std::size_t k = 0; k < problem.size(); ++k) {
        const Eigen::Vector3d image = turn * vector(problem.source, k);
        for (std::size_t j = 0; j < problem.size(); ++j) images += (vector(problem.source, j) - image).norm() < 1e-9;
        decoys += (vector(problem.target, k) - problem.T_target_source * image).norm() < 1e-9;
      }
      EXPECT_EQ(images, 200u);
      EXPECT_EQ(inlier_count(problem), 100u);
      EXPECT_EQ(decoys, static_cast<std::size_t>(100.0 * share));
    }
  }
}

TEST(HardProblem, ScenesHaveTheirShape) {
  const double cube = 100.0 / std::sqrt(3.0);
  const auto deviations = [](Scene scene, double thickness) {
    return principal_deviations(hard_problem({.scene = scene, .thickness = thickness}).source);
  };
  const Eigen::Vector3d volume = deviations(Scene::volume, 0.0);
  const Eigen::Vector3d slab = deviations(Scene::planar, 0.5), rod = deviations(Scene::linear, 0.5);
  const double thin = 0.25 / std::sqrt(3.0);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(volume[axis] / cube, 1.0, 0.05);
    EXPECT_NEAR(slab[axis] / (axis < 1 ? thin : cube), 1.0, 0.05);
    EXPECT_NEAR(rod[axis] / (axis < 2 ? thin : cube), 1.0, 0.05);
  }
  EXPECT_LT(deviations(Scene::planar, 0.0)[0], 1e-5);
  EXPECT_LT(deviations(Scene::linear, 0.0)[1], 1e-5);
  // Turned at random: no axis is special.
  const Problem plane = hard_problem({.scene = Scene::planar, .thickness = 0.0});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double largest = 0.0;
    for (std::size_t k = 0; k < plane.size(); ++k) largest = std::max(largest, std::abs(plane.source[3 * k + axis]));
    EXPECT_GT(largest, 1.0);
  }
}

TEST(HardProblem, NoiseModelsHaveTheirDeviation) {
  for (const NoiseModel noise : {NoiseModel::gaussian, NoiseModel::range_dependent, NoiseModel::student_t}) {
    const Problem problem = hard_problem(
        {.correspondences = 40000, .outlier_ratio = 0.0, .sigma = 0.5, .noise = noise, .degrees_of_freedom = 6});
    double squares = 0.0;
    for (std::size_t k = 0; k < problem.size(); ++k) squares += residual(problem, k).squaredNorm();
    // Fourth moments: 3 (Gaussian), 3.8 (range), 6 (t with 6 degrees): the mean of 40 000 rows is good to 1 %.
    EXPECT_NEAR(std::sqrt(squares / (3.0 * 40000.0)), 0.5, 0.01);
  }
}

TEST(HardProblem, RangeDependentNoiseGrowsWithRange) {
  const Problem problem = hard_problem(
      {.correspondences = 40000, .outlier_ratio = 0.0, .sigma = 0.5, .noise = NoiseModel::range_dependent});
  // |p| has mean square 100^2 on the cube, so the deviation is 0.005 |p| everywhere.
  for (const double range : {30.0, 60.0, 90.0, 120.0}) {
    double squares = 0.0, count = 0.0;
    for (std::size_t k = 0; k < problem.size(); ++k) {
      const double p = vector(problem.source, k).norm();
      if (std::abs(p - range) > 5.0) continue;
      squares += residual(problem, k).squaredNorm() / (p * p);
      count += 3.0;
    }
    EXPECT_NEAR(std::sqrt(squares / count), 0.005, 0.005 * 4.0 / std::sqrt(2.0 * count)) << range;
  }
}

TEST(HardProblem, StudentNoiseHasHeavyTails) {
  const auto share_beyond = [](NoiseModel noise, double deviations) {
    const Problem problem =
        hard_problem({.correspondences = 40000, .outlier_ratio = 0.0, .sigma = 1.0, .noise = noise});
    std::size_t beyond = 0;
    for (std::size_t k = 0; k < problem.size(); ++k) beyond += std::abs(residual(problem, k).x()) > deviations;
    return static_cast<double>(beyond) / 40000.0;
  };
  // P(|t_3| > 5 sqrt 3) = 0.00324, the Gaussian's is 6e-7.
  EXPECT_NEAR(share_beyond(NoiseModel::student_t, 5.0), 0.00324, 4.0 * std::sqrt(0.00324 / 40000.0));
  EXPECT_LT(share_beyond(NoiseModel::gaussian, 5.0), 1e-4);
}

TEST(HardProblem, MirroredDataHaveNoRotation) {
  const Problem problem = hard_problem({.correspondences = 300, .outlier_ratio = 0.0, .sigma = 0.01, .mirrored = true});
  EXPECT_EQ(inlier_count(problem), 0u);
  EXPECT_GT(problem.T_target_source.linear().determinant(), 0.0);
  EXPECT_GT(residual_of_best_motion(outliers_as_inliers(problem)), 30.0);
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const Eigen::Vector3d source = vector(problem.source, k).cwiseProduct(Eigen::Vector3d(-1, 1, 1));
    EXPECT_LT((vector(problem.target, k) - problem.T_target_source * source).norm(), 0.1);
  }
}

TEST(HardProblem, QuantumRoundsBothClouds) {
  const HardProblemOptions exact{.correspondences = 200, .sigma = 0.1};
  HardProblemOptions coarse = exact;
  coarse.quantum = 0.25;
  const Problem fine = hard_problem(exact), rounded = hard_problem(coarse);
  for (const auto cloud : {&Problem::source, &Problem::target}) {
    for (std::size_t i = 0; i < (fine.*cloud).size(); ++i) {
      EXPECT_EQ(std::remainder((rounded.*cloud)[i], 0.25), 0.0);
      EXPECT_LE(std::abs((rounded.*cloud)[i] - (fine.*cloud)[i]), 0.125);
    }
  }
}

TEST(HardProblem, DuplicatesAreCopiesOfRows) {
  const Problem problem = hard_problem({.correspondences = 100, .outlier_ratio = 0.5, .duplicates = 40});
  ASSERT_EQ(problem.size(), 140u);
  std::map<std::pair<Point, Point>, std::set<int>> labels;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    labels[{point(problem.source, k), point(problem.target, k)}].insert(problem.is_inlier[k]);
  }
  EXPECT_EQ(labels.size(), 100u);
  for (const auto& [row, of_row] : labels) EXPECT_EQ(of_row.size(), 1u);
}

TEST(HardProblem, OffsetsAndUnitsMoveThePoseAlong) {
  const HardProblemOptions plain{.correspondences = 200, .outlier_ratio = 0.5, .sigma = 0.1};
  HardProblemOptions moved = plain;
  moved.source_offset = {5e6, -3e5, 120.0};
  moved.target_offset = {-1e5, 4e6, 0.0};
  moved.units_per_metre = 1000.0;
  const Problem near = hard_problem(plain), far = hard_problem(moved);
  EXPECT_EQ(near.is_inlier, far.is_inlier);
  EXPECT_EQ(far.sigma, 100.0);
  for (std::size_t k = 0; k < near.size(); ++k) {
    const Eigen::Vector3d expected = 1000.0 * (vector(near.source, k) + Eigen::Vector3d(5e6, -3e5, 120.0));
    EXPECT_LT((vector(far.source, k) - expected).norm(), 1e-5);
    EXPECT_LT((residual(far, k) - 1000.0 * residual(near, k)).norm(), 1e-4);
  }
}

TEST(HardProblem, BadOptionsAreNamed) {
  const auto message = [](auto change) -> std::string {
    HardProblemOptions options;
    change(options);
    try {
      static_cast<void>(hard_problem(options));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using O = HardProblemOptions;
  EXPECT_EQ(message([](O& o) { o.thickness = -0.5; }), "thickness = -0.5: expected a finite number >= 0");
  EXPECT_EQ(message([](O& o) { o.clusters = 0; }), "clusters = 0: expected 1 to 4294967295");
  EXPECT_EQ(message([](O& o) { o.parts = 0; }), "parts = 0: expected 1 to 4294967295");
  EXPECT_EQ(message([](O& o) { o.cluster_sigma = -1; }), "cluster_sigma = -1: expected a finite number >= 0");
  EXPECT_EQ(message([](O& o) { o.matches_per_point = 1; }), "matches_per_point = 1: expected at least 2");
  EXPECT_EQ(message([=](O& o) { o.decoy_share = nan; }), "decoy_share = nan: expected a finite number >= 0");
  EXPECT_EQ(message([](O& o) { o.decoy_share = 9.5; }), "decoy_share = 9.5: expected no more decoys than outliers");
  EXPECT_EQ(message([](O& o) { o.outlier_ratio = 1.1; }), "outlier_ratio = 1.1: expected a number in [0, 1]");
  EXPECT_EQ(message([](O& o) { o.degrees_of_freedom = 2; }), "degrees_of_freedom = 2: expected at least 3");
  EXPECT_EQ(message([](O& o) { o.quantum = -1; }), "quantum = -1: expected a finite number >= 0");
  EXPECT_EQ(message([](O& o) { o.duplicates = ~std::size_t{0}; }),
            "duplicates = 18446744073709551615: expected at most 4294967295 rows with the correspondences");
  EXPECT_EQ(message([=](O& o) { o.source_offset[1] = nan; }), "source_offset = nan: expected a finite number");
  EXPECT_EQ(message([=](O& o) { o.target_offset[2] = -nan; }).substr(0, 13), "target_offset");
  EXPECT_EQ(message([](O& o) { o.scale = -2; }), "scale = -2: expected a finite number > 0");
  EXPECT_EQ(message([](O& o) { o.units_per_metre = 0; }), "units_per_metre = 0: expected a finite number > 0");
}

TEST(HardProblem, ScaleShrinksTheSourceAlone) {
  const Problem plain = hard_problem({.correspondences = 200, .outlier_ratio = 0.5});
  const Problem scaled = hard_problem({.correspondences = 200, .outlier_ratio = 0.5, .scale = 4.0});
  EXPECT_EQ(plain.scale, 1.0);
  EXPECT_EQ(scaled.scale, 4.0);
  EXPECT_EQ(scaled.target, plain.target);
  EXPECT_EQ(scaled.T_target_source.matrix(), plain.T_target_source.matrix());
  for (std::size_t k = 0; k < plain.source.size(); ++k) EXPECT_EQ(4.0 * scaled.source[k], plain.source[k]);
  EXPECT_EQ(rmse_true_inliers(scaled, scaled.T_target_source, 4.0), rmse_true_inliers(plain, plain.T_target_source));
  EXPECT_EQ(oracle(scaled).matrix(), oracle(plain).matrix());
  EXPECT_NEAR(scale_error(4.2, scaled.scale), 0.05, 1e-12);
}

}  // namespace
}  // namespace consimd::synth
