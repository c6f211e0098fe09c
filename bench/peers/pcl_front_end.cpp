// The Point Cloud Library's way from two scans to a pose, stage by stage, for front_ends.py:
//   consimd_pcl_front_end SOURCE TARGET VOXEL KEYPOINTS SEED OUT
// SOURCE and TARGET hold x y z of each point as float32. OUT.source and OUT.target get a row for each keypoint, its x y
// z and the 33 numbers of its descriptor as float32. Standard output gets a line: seconds of each stage, and the pose.
#include <pcl/common/io.h>
#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/filter.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#include <pcl/registration/correspondence_estimation.h>
#include <pcl/registration/correspondence_rejection_sample_consensus.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Normals = pcl::PointCloud<pcl::Normal>;
using Descriptors = pcl::PointCloud<pcl::FPFHSignature33>;

// In voxels, as front_ends.py has them for all.
constexpr double kNormalRadius = 2.0;
constexpr double kDescriptorRadius = 5.0;
constexpr double kInlierBound = 2.0;
constexpr int kIterations = 50000;

/// What each stage took.
using Seconds = std::map<std::string, double>;

template <typename Work>
void timed(Seconds& seconds, const std::string& stage, const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  seconds[stage] += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::vector<std::array<float, 3>> points_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) throw std::runtime_error(path + ": cannot read");
  std::vector<std::array<float, 3>> points(static_cast<std::size_t>(file.tellg()) / sizeof(std::array<float, 3>));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(points.data()), static_cast<std::streamsize>(points.size() * sizeof(points[0])));
  return points;
}

struct Side {
  Cloud::Ptr keypoints{new Cloud};
  Descriptors::Ptr descriptors{new Descriptors};
};

Side described(const std::vector<std::array<float, 3>>& points, double voxel, std::size_t most, std::mt19937_64& random,
               Seconds& seconds) {
  const Cloud::Ptr raw(new Cloud), voxels(new Cloud), cloud(new Cloud);
  raw->reserve(points.size());
  for (const auto& p : points) raw->emplace_back(p[0], p[1], p[2]);
  timed(seconds, "voxel_grid", [&] {
    const auto leaf = static_cast<float>(voxel);
    pcl::VoxelGrid<pcl::PointXYZ> grid;
    grid.setInputCloud(raw);
    grid.setLeafSize(leaf, leaf, leaf);
    grid.filter(*voxels);
  });
  const pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
  const Normals::Ptr normals(new Normals);
  timed(seconds, "normals", [&] {
    pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setInputCloud(voxels);
    estimation.setSearchMethod(tree);
    estimation.setRadiusSearch(kNormalRadius * voxel);
    estimation.setViewPoint(0.0F, 0.0F, 0.0F);
    estimation.compute(*normals);
    // Descriptors take no point without a normal.
    pcl::Indices kept;
    pcl::removeNaNNormalsFromPointCloud(*normals, *normals, kept);
    pcl::copyPointCloud(*voxels, kept, *cloud);
  });
  std::vector<int> rows(cloud->size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<int>(i);
  std::shuffle(rows.begin(), rows.end(), random);
  rows.resize(std::min(rows.size(), most));
  std::sort(rows.begin(), rows.end());
  Side side;
  pcl::copyPointCloud(*cloud, rows, *side.keypoints);
  timed(seconds, "fpfh", [&] {
    pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
    estimation.setInputCloud(side.keypoints);
    estimation.setSearchSurface(cloud);
    estimation.setInputNormals(normals);
    estimation.setSearchMethod(tree);
    estimation.setRadiusSearch(kDescriptorRadius * voxel);
    estimation.compute(*side.descriptors);
  });
  return side;
}

void write(const std::string& path, const Side& side) {
  std::ofstream file(path, std::ios::binary);
  for (std::size_t i = 0; i < side.keypoints->size(); ++i) {
    file.write(reinterpret_cast<const char*>((*side.keypoints)[i].data), 3 * sizeof(float));
    file.write(reinterpret_cast<const char*>((*side.descriptors)[i].histogram), 33 * sizeof(float));
  }
  if (!file) throw std::runtime_error(path + ": cannot write");
}

void run(const std::vector<std::string>& words) {
  if (words.size() != 6) throw std::runtime_error("expected SOURCE TARGET VOXEL KEYPOINTS SEED OUT");
  const double voxel = std::stod(words[2]);
  const auto most = static_cast<std::size_t>(std::stoul(words[3]));
  std::mt19937_64 random(std::stoull(words[4]));
  const auto source_points = points_of(words[0]), target_points = points_of(words[1]);
  Seconds seconds;
  const Side source = described(source_points, voxel, most, random, seconds);
  const Side target = described(target_points, voxel, most, random, seconds);

  const pcl::CorrespondencesPtr matches(new pcl::Correspondences);
  timed(seconds, "matches", [&] {
    pcl::registration::CorrespondenceEstimation<pcl::FPFHSignature33, pcl::FPFHSignature33> estimation;
    estimation.setInputSource(source.descriptors);
    estimation.setInputTarget(target.descriptors);
    estimation.determineReciprocalCorrespondences(*matches);
  });
  pcl::registration::CorrespondenceRejectorSampleConsensus<pcl::PointXYZ> rejector;
  timed(seconds, "registration", [&] {
    rejector.setInputSource(source.keypoints);
    rejector.setInputTarget(target.keypoints);
    rejector.setInputCorrespondences(matches);
    rejector.setInlierThreshold(kInlierBound * voxel);
    rejector.setMaximumIterations(kIterations);
    pcl::Correspondences inliers;
    rejector.getCorrespondences(inliers);
  });
  write(words[5] + ".source", source);
  write(words[5] + ".target", target);

  std::cout << R"({"version": ")" << PCL_VERSION_PRETTY << R"(", "seconds": {)";
  const char* before = "";
  for (const auto& [stage, spent] : seconds) {
    std::cout << before << '"' << stage << "\": " << spent;
    before = ", ";
  }
  std::cout << R"(}, "T_target_source": [)";
  const Eigen::Matrix4f pose = rejector.getBestTransformation();
  for (Eigen::Index k = 0; k < 16; ++k) std::cout << (k == 0 ? "" : ", ") << pose(k / 4, k % 4);
  std::cout << "]}\n";
}

}  // namespace

int main(int count, char** words) {
  try {
    run({words + 1, words + count});
  } catch (const std::exception& error) {
    std::cerr << "consimd_pcl_front_end: " << error.what() << '\n';
    return 2;
  }
  return 0;
}
