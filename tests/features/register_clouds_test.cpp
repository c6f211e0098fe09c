#include <consimd/features/register_clouds.hpp>
#include <consimd/features/voxel_grid.hpp>

#include <gtest/gtest.h>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <nlohmann/json.hpp>

#include <bit>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "scene.hpp"

namespace consimd::test {
namespace {

using features::CloudRegistration;
using features::register_clouds;

double rotation_error_deg(const RigidTransform& a, const RigidTransform& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() * 57.2957795;
}

TEST(RegisterClouds, FindsThePose) {
  for (const double offset : {0.0, 3e6}) {
    RigidTransform pose = some_pose();
    const Points source = room(60000, 1);
    Points target = moved(pose, room(60000, 2));
    for (auto& p : target) p[0] += offset;
    pose.translation().x() += offset;
    features::CloudRegistrationOptions options;
    options.matching.source_viewpoint = {0.0, 0.0, 1.5};
    const Eigen::Vector3d seen_from = pose * Eigen::Vector3d(0.0, 0.0, 1.5);
    options.matching.target_viewpoint = {seen_from.x(), seen_from.y(), seen_from.z()};
    const CloudRegistration result = register_clouds(cloud_of(source), cloud_of(target), options);
    EXPECT_EQ(result.registration.status, Status::success);
    EXPECT_LT(rotation_error_deg(result.registration.T_target_source, pose), 1.0);
    EXPECT_LT((result.registration.T_target_source.translation() - pose.translation()).norm(), 0.1);
    EXPECT_EQ(result.matches.correspondences.size(), result.matches.matches.size());
    EXPECT_GT(result.matches.source.voxels, 6000u);
    EXPECT_TRUE(result.matches.hint.empty()) << result.matches.hint;
    EXPECT_DOUBLE_EQ(result.registration.noise_bound, result.matches.noise_bound);
  }
}

/// All that must not vary.
std::vector<std::uint64_t> bits_of(const CloudRegistration& result) {
  std::vector<std::uint64_t> bits;
  for (const double x : result.registration.T_target_source.matrix().reshaped())
    bits.push_back(std::bit_cast<std::uint64_t>(x));
  for (const double x : {result.matches.voxel, result.matches.noise_bound, result.matches.source.resolution}) {
    bits.push_back(std::bit_cast<std::uint64_t>(x));
  }
  for (const features::Match& m : result.matches.matches) {
    bits.insert(bits.end(), {m.source, m.target, std::bit_cast<std::uint32_t>(m.distance)});
  }
  for (const auto& p : result.matches.source_points) {
    for (const double x : p) bits.push_back(std::bit_cast<std::uint64_t>(x));
  }
  for (const StageReport& stage : result.matches.stages) bits.insert(bits.end(), {stage.input, stage.output});
  return bits;
}

TEST(RegisterClouds, HasTheSameBitsForAnyThreadsAndInstructionSet) {
  const Cloud source = cloud_of(room(150000, 1)), target = cloud_of(moved(some_pose(), room(20000, 2)));
  features::CloudRegistrationOptions options;
  options.matching.keypoints = 1500;
  std::vector<std::uint64_t> expected;
  for (const Isa isa : supported_isas()) {
    set_active_isa(isa);
    for (const int threads : {1, 2, 4}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 4);
      tbb::task_arena arena(threads);
      const std::vector<std::uint64_t> bits =
          arena.execute([&] { return bits_of(register_clouds(source, target, options)); });
      if (expected.empty()) expected = bits;
      EXPECT_TRUE(bits == expected) << to_string(isa) << " on " << threads;
    }
  }
  set_active_isa(supported_isas().back());
}

TEST(RegisterClouds, OfDegenerateCloudsHasNoPose) {
  Points line, plane;
  for (int i = 0; i < 2000; ++i) line.push_back({0.01 * i, 0.0, 0.0});
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) plane.push_back({0.1 * j, 0.1 * i, 0.0});
  }
  for (const Points& points : {Points{{1, 2, 3}}, Points(50, {1, 2, 3}), Points{{0, 0, 0}, {1, 0, 0}}, line, plane}) {
    const CloudRegistration result = register_clouds(cloud_of(points), cloud_of(points));
    EXPECT_NE(result.registration.status, Status::success) << points.size();
    EXPECT_TRUE(std::isfinite(result.matches.noise_bound));
  }
}

std::string fault(const Cloud& source, const Cloud& target, const features::CloudRegistrationOptions& options) {
  try {
    static_cast<void>(register_clouds(source, target, options));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing";
}

TEST(RegisterClouds, NamesWhatIsWrong) {
  const Cloud cloud = cloud_of(room(1000, 1));
  EXPECT_EQ(fault(Cloud(), cloud, {}), "the source cloud is empty");
  const Points nowhere{{std::nan(""), 0, 0}};
  EXPECT_EQ(fault(cloud, cloud_of(nowhere), {}), "the target cloud is empty: all of its 1 rows are without a place");
  features::CloudRegistrationOptions options;
  options.matching.voxel = 300.0;
  EXPECT_NE(fault(cloud, cloud, options).find("voxel is 300"), std::string::npos);
  options.matching.voxel = 1e-7;
  EXPECT_NE(fault(cloud, cloud, options).find("voxel is 1e-07"), std::string::npos) << fault(cloud, cloud, options);
  options.matching.voxel = 0.2;
  options.matching.normal_radius = 6.0;
  EXPECT_NE(fault(cloud, cloud, options).find("normal_radius"), std::string::npos);
  options = {};
  options.solver = "unheard-of";
  EXPECT_NE(fault(cloud, cloud, options).find("unheard-of"), std::string::npos);
}

TEST(RegisterClouds, ChoosesAVoxelForCloudsOfAnySize) {
  const auto voxels = [](const Points& points) {
    const Cloud cloud = cloud_of(points);
    return static_cast<double>(features::occupied_voxels(cloud, features::choose_voxel(cloud)));
  };
  for (const std::size_t size : {200u, 2000u, 12000u})
    EXPECT_NEAR(voxels(room(size, 1)) / (0.75 * static_cast<double>(size)), 1.0, 0.1);
  EXPECT_NEAR(voxels(room(100000, 1)) / 12000.0, 1.0, 0.1);
  Points volume;  // whose voxels become fewer with the third power of their side
  for (int i = 0; i < 1000; ++i) volume.push_back({(i * 377) % 1000 / 1e3, (i * 611) % 1000 / 1e3, i / 1e3});
  EXPECT_NEAR(voxels(volume) / 750.0, 1.0, 0.1);
}

TEST(RegisterClouds, ChoosesTheVoxelByTheBulk) {
  for (const std::size_t size : {200u, 20000u}) {
    const Points points = room(size, 1);
    const double expected = features::choose_voxel(cloud_of(points));
    for (const std::size_t strays : {1u, 3u, 15u}) {
      for (const double far : {3e4, 1e7, 1e15}) {
        Points with = points;
        for (std::size_t k = 0; k < strays; ++k) with.push_back({far, far + 0.1 * static_cast<double>(k), -far});
        EXPECT_EQ(features::choose_voxel(cloud_of(with)), expected) << size << " points, " << strays << " at " << far;
      }
    }
  }
  // The whole registration is that of the clouds without it.
  const Points source = room(30000, 1), target = moved(some_pose(), room(30000, 2));
  Points with = source;
  with.insert(with.begin(), {1e7, 0.0, 0.0});
  const CloudRegistration found = register_clouds(cloud_of(with), cloud_of(target));
  EXPECT_EQ(found.registration.T_target_source.matrix(),
            register_clouds(cloud_of(source), cloud_of(target)).registration.T_target_source.matrix());
  EXPECT_EQ(found.matches.source.left_out, 1u);
  EXPECT_EQ(found.registration.status, Status::success);
}

TEST(RegisterClouds, DrawsFromIssKeypoints) {
  features::CloudMatchingOptions options{.voxel = 0.15, .keypoints = std::nullopt, .iss = true};
  const Cloud source = cloud_of(room(20000, 1));
  const Cloud target = cloud_of(room(20000, 2));
  const features::CloudMatches all = features::match_clouds(source, target, options);
  EXPECT_EQ(all.stages[2].name, "iss");
  EXPECT_GT(all.source.descriptors, 100u);
  EXPECT_LT(all.source.descriptors, all.source.voxels / 10);
  options.keypoints = 50;
  EXPECT_EQ(features::match_clouds(source, target, options).source.descriptors, 50u);
  options.iss_suppression_radius = 9.0;
  EXPECT_NE(fault(source, target, {.matching = options}).find("iss_suppression_radius is 9"), std::string::npos);
}

TEST(RegisterClouds, HintsAtACloudOfOnePlace) {
  const features::CloudMatches matches =
      features::match_clouds(cloud_of(Points(50, {1.0, 2.0, 3.0})), cloud_of(room(3000, 1)));
  EXPECT_EQ(matches.hint, "all points of the source cloud lie in one place");
  EXPECT_TRUE(matches.matches.empty());
}

TEST(RegisterClouds, HintsAtDifferentUnits) {
  Points millimetres = room(3000, 2);
  for (auto& p : millimetres) {
    for (double& x : p) x *= 1000.0;
  }
  features::CloudMatchingOptions options;
  options.keypoints = 200;
  EXPECT_NE(
      features::match_clouds(cloud_of(room(3000, 1)), cloud_of(millimetres), options).hint.find("target cloud is"),
      std::string::npos);
}

TEST(RegisterClouds, HintsAtVoxelsThatHoldAPointEach) {
  features::CloudMatchingOptions options;
  options.voxel = 1e-4;
  const features::CloudMatches found =
      features::match_clouds(cloud_of(room(3000, 1)), cloud_of(room(3000, 2)), options);
  EXPECT_TRUE(found.matches.empty());
  EXPECT_NE(found.hint.find("a voxel of 0.0001 is too small, "), std::string::npos);
}

Cloud read_kitti(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<float> rows(std::filesystem::file_size(path) / sizeof(float));
  file.read(reinterpret_cast<char*>(rows.data()), static_cast<std::streamsize>(rows.size() * sizeof(float)));
  return Cloud(PointSpan<float>{rows.data(), rows.size() / 4, 4, 1});
}

TEST(RegisterClouds, FindsThePosesOfScans) {
  const char* data = std::getenv("CONSIMD_TEST_DATA");
  if (data == nullptr) GTEST_SKIP() << "set CONSIMD_TEST_DATA to the folder with scans/pairs.json";
  const std::filesystem::path folder = std::filesystem::path(data) / "scans";
  std::ifstream file(folder / "pairs.json");
  int registered = 0;
  for (const auto& pair : nlohmann::json::parse(file)) {
    const auto path = [&](const char* side) { return folder / pair.at(side).get<std::string>(); };
    if (path("source").extension() != ".bin") continue;
    RigidTransform pose = RigidTransform::Identity();
    for (Eigen::Index r = 0; r < 3; ++r) {
      for (Eigen::Index c = 0; c < 4; ++c) {
        pose.matrix()(r, c) =
            pair.at("T_target_source").at(static_cast<std::size_t>(r)).at(static_cast<std::size_t>(c)).get<double>();
      }
    }
    // Of scans more than 20 m apart too few matches are left for every draw of points.
    if (pose.translation().norm() > 20.0) continue;
    features::CloudRegistrationOptions options;
    options.matching.voxel = pair.at("voxel").get<double>();
    const CloudRegistration result = register_clouds(read_kitti(path("source")), read_kitti(path("target")), options);
    EXPECT_EQ(result.registration.status, Status::success) << pair.at("name");
    EXPECT_LT(rotation_error_deg(result.registration.T_target_source, pose), 5.0) << pair.at("name");
    EXPECT_LT((result.registration.T_target_source.translation() - pose.translation()).norm(), 0.6) << pair.at("name");
    ++registered;
  }
  EXPECT_GT(registered, 0);
}

}  // namespace
}  // namespace consimd::test
