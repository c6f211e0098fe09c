#include <consimd/features/refinement.hpp>

#include <consimd/features/cell_grid.hpp>
#include <consimd/features/cloud_files.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/features/register_clouds.hpp>
#include <consimd/features/voxel_grid.hpp>

#include <gtest/gtest.h>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "scene.hpp"

namespace consimd::test {
namespace {

using features::CellGrid;
using features::Refinement;
using features::RefinementMethod;
using features::RefinementOptions;
using features::RefinementStatus;

constexpr RefinementMethod kMethods[] = {RefinementMethod::point, RefinementMethod::plane, RefinementMethod::gicp};

struct Errors {
  double rotation_deg;
  double translation;
};

Errors errors_of(const RigidTransform& pose, const RigidTransform& truth) {
  return {Eigen::AngleAxisd(pose.linear().transpose() * truth.linear()).angle() * 57.2957795,
          (pose.translation() - truth.translation()).norm()};
}

/// Thinned out, with normals.
Cloud prepared(const Cloud& cloud, double voxel) {
  CellGrid grid(features::voxel_grid(cloud, voxel), 2.0 * voxel);
  features::estimate_normals(grid, {.radius = 2.0 * voxel});
  std::vector<std::uint32_t> rows(grid.size());
  for (std::uint32_t row = 0; row < rows.size(); ++row) rows[row] = row;
  return grid.cloud().subset(rows);
}

/// Off by about `angle` rad and `shift`.
RigidTransform near(const RigidTransform& pose, double angle, double shift) {
  RigidTransform start = pose;
  start.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d(0.6, -0.64, 0.48)));
  start.translation() += shift * Eigen::Vector3d(0.48, 0.6, -0.64);
  return start;
}

TEST(Refinement, ComesNearTheTruth) {
  for (const double offset : {0.0, 3e6}) {
    RigidTransform truth = some_pose();
    Points moved_room = moved(truth, room(60000, 2));
    for (auto& p : moved_room) p[0] += offset;
    truth.translation().x() += offset;
    const Cloud source = prepared(cloud_of(room(60000, 1)), 0.1), target = prepared(cloud_of(moved_room), 0.1);
    const RigidTransform start = near(truth, 0.02, 0.08);
    for (const RefinementMethod method : kMethods) {
      const Refinement refined = features::refine(source, target, start, {.method = method, .max_distance = 0.4});
      EXPECT_EQ(refined.status, RefinementStatus::converged) << to_string(method);
      const Errors errors = errors_of(refined.T_target_source, truth);
      // Points of two samples are not the same points: what is between them shows where points are compared.
      const double most = method == RefinementMethod::point ? 0.02 : 0.004;
      EXPECT_LT(errors.rotation_deg, 20.0 * most) << to_string(method);
      EXPECT_LT(errors.translation, most) << to_string(method);
      EXPECT_GT(refined.inlier_share, 0.95);
      EXPECT_GT(refined.pairs, 3000u);
      EXPECT_LT(refined.rmse, 0.1);
      EXPECT_GT(refined.iterations, 1u);
      EXPECT_NEAR(refined.T_target_source.linear().determinant(), 1.0, 1e-9);
      const Eigen::Matrix<double, 6, 6> covariance = refined.covariance;
      EXPECT_TRUE(covariance.allFinite());
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).eigenvalues().minCoeff(), 0.0);
      EXPECT_GE(refined.shared_errors, 1.0);
    }
  }
}

TEST(Refinement, CovarianceFitsTheErrors) {
  // With independent noise and the other half of one scan's points: d^T C^-1 d has the mean 6.
  double sum = 0.0;
  constexpr int kTrials = 12;
  for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
    const RigidTransform truth = some_pose();
    const Cloud source = prepared(cloud_of(room(30000, 2 * trial + 1)), 0.15);
    const Cloud target = prepared(cloud_of(moved(truth, room(30000, 2 * trial + 2))), 0.15);
    const Refinement refined = features::refine(source, target, near(truth, 0.01, 0.05), {.max_distance = 0.4});
    ASSERT_EQ(refined.status, RefinementStatus::converged);
    const Eigen::AngleAxisd turn(truth.linear() * refined.T_target_source.linear().transpose());
    Eigen::Matrix<double, 6, 1> error;
    error << turn.angle() * turn.axis(), truth.translation() - refined.T_target_source.translation();
    sum += error.dot(Eigen::Matrix<double, 6, 6>(refined.covariance).ldlt().solve(error));
  }
  EXPECT_GT(sum / kTrials, 2.0);
  EXPECT_LT(sum / kTrials, 12.0);
}

/// All that must not vary.
std::vector<std::uint64_t> bits_of(const Refinement& refined) {
  std::vector<std::uint64_t> bits{refined.iterations, refined.pairs};
  for (const double x : refined.T_target_source.matrix().reshaped()) bits.push_back(std::bit_cast<std::uint64_t>(x));
  for (const double x : refined.covariance.reshaped()) bits.push_back(std::bit_cast<std::uint64_t>(x));
  for (const double x : {refined.rmse, refined.inlier_share, refined.shared_errors, refined.residual_scale}) {
    bits.push_back(std::bit_cast<std::uint64_t>(x));
  }
  return bits;
}

TEST(Refinement, HasTheSameBitsForAnyThreadsAndInstructionSet) {
  const RigidTransform truth = some_pose();
  const Cloud source = prepared(cloud_of(room(20000, 1)), 0.1);
  const Cloud target = prepared(cloud_of(moved(truth, room(20000, 2))), 0.1);
  for (const RefinementMethod method : kMethods) {
    std::vector<std::uint64_t> expected;
    for (const Isa isa : supported_isas()) {
      set_active_isa(isa);
      for (const int threads : {1, 2, 4}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 4);
        tbb::task_arena arena(threads);
        const std::vector<std::uint64_t> bits = arena.execute(
            [&] { return bits_of(features::refine(source, target, near(truth, 0.02, 0.05), {.method = method})); });
        if (expected.empty()) expected = bits;
        EXPECT_TRUE(bits == expected) << to_string(method) << ", " << to_string(isa) << " on " << threads;
      }
    }
  }
  set_active_isa(supported_isas().back());
}

Points plane(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  Points points(count);
  for (auto& p : points) p = {5.0 * uniform(random), 5.0 * uniform(random), 0.005 * uniform(random)};
  return points;
}

TEST(Refinement, NamesWhatLeavesAMotionFree) {
  const RigidTransform identity = RigidTransform::Identity();
  const Cloud first = prepared(cloud_of(plane(20000, 1)), 0.15), second = prepared(cloud_of(plane(20000, 2)), 0.15);
  for (const RefinementMethod method : {RefinementMethod::plane, RefinementMethod::gicp}) {
    RigidTransform start = identity;
    start.translation() << 0.0, 0.0, 0.1;
    const Refinement refined = features::refine(first, second, start, {.method = method, .max_distance = 0.5});
    EXPECT_EQ(refined.status, RefinementStatus::degenerate_geometry) << to_string(method);
    EXPECT_FALSE(refined.has_pose());
    EXPECT_TRUE(refined.covariance.isZero(0.0));
    // What the plane tells is taken, along it nothing has moved.
    EXPECT_NEAR(refined.T_target_source.translation().z(), 0.0, 2e-3) << to_string(method);
    EXPECT_LT(refined.T_target_source.translation().head<2>().norm(), 2e-3) << to_string(method);
  }
  Points line;
  for (int i = 0; i < 1000; ++i) line.push_back({0.01 * i, 0.0, 0.0});
  const Refinement of_line = features::refine(cloud_of(line), cloud_of(line), identity,
                                              {.method = RefinementMethod::point, .max_distance = 0.1});
  EXPECT_EQ(of_line.status, RefinementStatus::degenerate_geometry);
  const Points place(50, {1.0, 2.0, 3.0});
  const Refinement of_place =
      features::refine(cloud_of(place), cloud_of(place), identity, {.method = RefinementMethod::point});
  EXPECT_EQ(of_place.status, RefinementStatus::degenerate_geometry);
}

TEST(Refinement, OfCloudsWithoutOverlapHasTooFewPairs) {
  const Cloud cloud = prepared(cloud_of(room(20000, 1)), 0.15);
  RigidTransform away = RigidTransform::Identity();
  away.translation().x() = 100.0;
  const Cloud one = cloud_of(Points{{1.0, 2.0, 3.0}});
  RigidTransform far_away = away;
  far_away.translation().x() = 1e300;
  for (const RefinementMethod method : kMethods) {
    const RefinementOptions options{.method = method, .max_distance = 0.4};
    for (const RigidTransform& start : {away, far_away}) {
      const Refinement refined = features::refine(cloud, cloud, start, options);
      EXPECT_EQ(refined.status, RefinementStatus::too_few_pairs);
      EXPECT_EQ(refined.pairs, 0u);
      EXPECT_TRUE(refined.T_target_source.matrix() == start.matrix());
    }
    EXPECT_EQ(features::refine(cloud, Cloud(), away, options).status, RefinementStatus::too_few_pairs);
    EXPECT_EQ(features::refine(Cloud(), cloud, away, options).status, RefinementStatus::too_few_pairs);
  }
  const RefinementOptions points{.method = RefinementMethod::point};
  EXPECT_EQ(features::refine(one, one, RigidTransform::Identity(), points).status, RefinementStatus::too_few_pairs);
  EXPECT_EQ(features::refine(one, cloud, RigidTransform::Identity(), points).status, RefinementStatus::too_few_pairs);
  EXPECT_EQ(features::refine(cloud, one, RigidTransform::Identity(), points).status, RefinementStatus::too_few_pairs);
}

TEST(Refinement, StopsAtItsLimit) {
  const RigidTransform truth = some_pose();
  // The second cloud is one of which only some points are moved at first: in the end all of them count.
  for (const double voxel : {0.2, 0.08}) {
    const Cloud source = prepared(cloud_of(room(20000, 1)), voxel);
    const Cloud target = prepared(cloud_of(moved(truth, room(20000, 2))), voxel);
    EXPECT_EQ(source.size() > 8192, voxel == 0.08);
    const Refinement refined =
        features::refine(source, target, near(truth, 0.05, 0.2), {.max_distance = 0.5, .max_iterations = 1});
    EXPECT_EQ(refined.status, RefinementStatus::iteration_limit);
    EXPECT_EQ(refined.iterations, 1u);
    EXPECT_GT(refined.inlier_share, 0.8);
    EXPECT_FALSE(refined.has_pose());
  }
}

std::string fault(const Cloud& source, const Cloud& target, const RigidTransform& start,
                  const RefinementOptions& options) {
  try {
    static_cast<void>(features::refine(source, target, start, options));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Refinement, NamesWhatIsWrong) {
  const Cloud bare = cloud_of(room(100, 1));
  const Cloud whole = prepared(cloud_of(room(2000, 1)), 0.5);
  RigidTransform start = RigidTransform::Identity();
  EXPECT_NE(fault(whole, bare, start, {}).find("the target cloud has no normals"), std::string::npos);
  EXPECT_EQ(fault(bare, whole, start, {}), "nothing");
  EXPECT_NE(fault(bare, whole, start, {.method = RefinementMethod::gicp}).find("the source cloud has no normals"),
            std::string::npos);
  EXPECT_NE(fault(whole, whole, start, {.max_distance = -1.0}).find("max_distance is -1"), std::string::npos);
  EXPECT_NE(fault(whole, whole, start, {.max_iterations = 0}).find("max_iterations is 0"), std::string::npos);
  start.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(fault(whole, whole, start, {}).find("not finite"), std::string::npos);
  EXPECT_EQ(features::parse_refinement_method("gicp"), RefinementMethod::gicp);
  EXPECT_THROW(static_cast<void>(features::parse_refinement_method("icp")), std::invalid_argument);
}

TEST(Refinement, IsAStageOfARegistration) {
  const RigidTransform truth = some_pose();
  const Cloud source = cloud_of(room(60000, 1)), target = cloud_of(moved(truth, room(60000, 2)));
  features::CloudRegistrationOptions options;
  const auto plain = features::register_clouds(source, target, options);
  EXPECT_FALSE(plain.refinement);
  options.refine = RefinementMethod::plane;
  const auto refined = features::register_clouds(source, target, options);
  ASSERT_TRUE(refined.refinement);
  EXPECT_TRUE(refined.refinement->has_pose());
  EXPECT_EQ(refined.registration.inliers, plain.registration.inliers);
  EXPECT_EQ(refined.registration.stages.back().name, "refine");
  EXPECT_EQ(refined.registration.stages.back().output, refined.refinement->pairs);
  EXPECT_TRUE(refined.registration.T_target_source.matrix() == refined.refinement->T_target_source.matrix());
  const Errors before = errors_of(plain.registration.T_target_source, truth);
  const Errors after = errors_of(refined.registration.T_target_source, truth);
  EXPECT_LT(after.translation, 0.5 * before.translation);
  EXPECT_LT(after.rotation_deg, 0.5 * before.rotation_deg);
}

TEST(Refinement, MakesThePosesOfScansMoreExact) {
  const char* data = std::getenv("CONSIMD_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "set CONSIMD_TEST_DATA to the folder with scans/pairs.json";
  const std::filesystem::path folder = std::filesystem::path(data) / "scans";
  std::ifstream file(folder / "pairs.json");
  int refined_pairs = 0, nearer = 0;
  for (const auto& pair : nlohmann::json::parse(file)) {
    const auto cloud = [&](const char* side) {
      return features::read_cloud(folder / pair.at(side).get<std::string>());
    };
    RigidTransform truth = RigidTransform::Identity();
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 4; ++c) {
        truth.matrix()(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) =
            pair.at("T_target_source").at(r).at(c).get<double>();
      }
    }
    features::CloudRegistrationOptions options;
    options.matching.voxel = pair.at("voxel").get<double>();
    auto found = features::register_clouds(cloud("source"), cloud("target"), options);
    const Errors before = errors_of(found.registration.T_target_source, truth);
    const bool outdoors = *options.matching.voxel > 0.1;
    // The limits within which the users of the data count a pose as found.
    const auto within = [&](const Errors& e) {
      return e.rotation_deg < (outdoors ? 5.0 : 15.0) && e.translation < (outdoors ? 0.6 : 0.3);
    };
    if (!found.registration.has_pose() || !within(before)) continue;
    // Root mean square distance of the source's points from where they belong.
    const auto miss = [&](const RigidTransform& pose) {
      const Cloud& source = found.matches.source_voxels->cloud();
      double sum = 0.0;
      for (std::size_t i = 0; i < source.size(); ++i) {
        const Eigen::Vector3d p(source.point(i).data());
        sum += (pose * p - truth * p).squaredNorm();
      }
      return std::sqrt(sum / static_cast<double>(source.size()));
    };
    const double missed = miss(found.registration.T_target_source);
    const Refinement refined =
        features::refine_registration(found.matches, RefinementMethod::plane, found.registration);
    const Errors after = errors_of(found.registration.T_target_source, truth);
    EXPECT_TRUE(within(after)) << pair.at("name");
    EXPECT_TRUE(refined.has_pose()) << pair.at("name");
    // The truths of rooms are good to a degree, which is more than the poses are off. One that the clouds found is
    // refined already.
    if (!outdoors || found.verdict->found_by_clouds) continue;
    ++refined_pairs;
    nearer += refined.has_pose() && miss(found.registration.T_target_source) < missed ? 1 : 0;
  }
  EXPECT_GT(refined_pairs, 0);
  EXPECT_GE(5 * nearer, 4 * refined_pairs);
}

}  // namespace
}  // namespace consimd::test
