// Small data sets of made-up scans, one in each layout.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <consimd/poses/rigid_fit.hpp>

#include "temporary_folder.hpp"

namespace consimd::studies::test {

using consimd::test::write_text;

/// Turned about z by `angle`, then moved.
inline RigidTransform moved(double angle, double x, double y, double z) {
  RigidTransform pose = RigidTransform::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

/// Numbers in [0, 1), one after the other.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15U + 1) {}
  double next() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 40U) / 16777216.0;
  }

 private:
  std::uint64_t state_;
};

/// Points of a room with boxes in which no two corners are alike, seen from `T_world_scanner`.
inline std::vector<std::array<float, 3>> room(std::uint64_t seed, const RigidTransform& T_world_scanner,
                                              std::size_t count = 6000) {
  Numbers draw(seed), boxes(1);
  std::vector<Eigen::Vector3d> corners, sizes;
  for (int k = 0; k < 12; ++k) {
    corners.emplace_back(8.0 * boxes.next() - 4.0, 8.0 * boxes.next() - 4.0, 0.0);
    sizes.emplace_back(0.3 + 0.9 * boxes.next(), 0.3 + 0.9 * boxes.next(), 0.5 + 1.5 * boxes.next());
  }
  const RigidTransform T_scanner_world = T_world_scanner.inverse();
  std::vector<std::array<float, 3>> points;
  for (std::size_t k = 0; k < count; ++k) {
    const double u = draw.next(), v = draw.next(), kind = draw.next();
    Eigen::Vector3d p;
    if (kind < 0.2) {
      p = {10.0 * u - 5.0, 10.0 * v - 5.0, 0.0};
    } else if (kind < 0.4) {
      p = {5.0, 10.0 * u - 5.0, 3.0 * v};
    } else if (kind < 0.6) {
      p = {4.0 * u - 4.0, 5.0, 3.0 * v};
    } else {
      const auto box = static_cast<std::size_t>(12.0 * draw.next());
      const auto side = static_cast<Eigen::Index>(3.0 * draw.next());
      Eigen::Vector3d share(u, v, u);
      share[side] = 1.0;
      share[(side + 1) % 3] = u;
      share[(side + 2) % 3] = v;
      p = corners[box] + sizes[box].cwiseProduct(share);
    }
    p += 0.02 * Eigen::Vector3d(draw.next() - 0.5, draw.next() - 0.5, draw.next() - 0.5);
    p = T_scanner_world * p;
    points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  }
  return points;
}

inline void append_floats(std::string& bytes, std::initializer_list<float> values) {
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (unsigned byte = 0; byte < 4; ++byte)
      bytes += static_cast<char>(static_cast<unsigned char>(bits >> (8U * byte)));
  }
}

/// KITTI's form.
inline std::string bin_of(const std::vector<std::array<float, 3>>& points) {
  std::string bytes;
  for (const auto& p : points) append_floats(bytes, {p[0], p[1], p[2], 0.5F});
  return bytes;
}

inline std::string ply_of(const std::vector<std::array<float, 3>>& points) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n",
      points.size());
  for (const auto& p : points) append_floats(bytes, {p[0], p[1], p[2]});
  return bytes;
}

inline std::string numbers_of(const RigidTransform& pose, int rows, const std::string& row_end) {
  std::string text;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < 4; ++c) text += fmt::format("{}{}", pose.matrix()(r, c), c < 3 ? " " : "");
    text += r + 1 < rows ? row_end : "";
  }
  return text;
}

/// Where the scanner was: three metres from one frame to the next.
inline RigidTransform place_of(std::uint32_t frame) { return moved(0.05 * frame, 3.0 * frame - 3.0, 0.2 * frame, 1.5); }

inline RigidTransform scanner_in_camera() {
  RigidTransform pose = RigidTransform::Identity();
  pose.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  pose.translation() = Eigen::Vector3d(0.0, -0.08, -0.27);
  return pose;
}

/// KITTI with frames 0, 1, 2 of one sequence, 3 m apart.
inline void write_kitti(const std::filesystem::path& root, const std::string& sequence = "03") {
  const std::filesystem::path folder = root / "sequences" / sequence;
  std::filesystem::create_directories(folder / "velodyne");
  std::filesystem::create_directories(root / "poses");
  write_text(folder / "calib.txt",
             fmt::format("P0: 1 0 0 0 0 1 0 0 0 0 1 0\nTr: {}\n", numbers_of(scanner_in_camera(), 3, " ")));
  std::string poses;
  for (std::uint32_t frame = 0; frame < 3; ++frame) {
    write_text(folder / "velodyne" / fmt::format("{:06}.bin", frame), bin_of(room(10 + frame, place_of(frame))));
    poses += numbers_of(place_of(frame) * scanner_in_camera().inverse(), 3, " ") + "\n";
  }
  write_text(root / "poses" / (sequence + ".txt"), poses);
}

inline RigidTransform between(std::uint32_t source, std::uint32_t target) {
  return place_of(target).inverse() * place_of(source);
}

/// A scene "hall" of ETH with scans s0, s1, s2 and two poses.
inline void write_eth(const std::filesystem::path& root) {
  std::filesystem::create_directories(root / "hall");
  for (std::uint32_t k = 0; k < 3; ++k) {
    write_text(root / "hall" / (k == 1 ? "s1_v0.1.ply" : fmt::format("s{}.ply", k)), ply_of(room(20 + k, place_of(k))));
  }
  write_text(root / "hall/s1-s0.pose", numbers_of(between(1, 0), 4, "\n") + "\n");
  write_text(root / "hall/s2-s1.pose", numbers_of(between(2, 1), 4, "\n") + "\n");
}

/// A scene "kitchen" of 3DMatch with fragments 0, 1, 2 and its evaluation's folder.
inline void write_3dmatch(const std::filesystem::path& root) {
  std::filesystem::create_directories(root / "kitchen");
  std::filesystem::create_directories(root / "kitchen-evaluation");
  std::string log, info;
  for (std::uint32_t k = 0; k < 3; ++k) {
    write_text(root / "kitchen" / fmt::format("cloud_bin_{}.ply", k), ply_of(room(30 + k, place_of(k))));
  }
  for (const auto& [i, j] : {std::pair(0U, 1U), std::pair(0U, 2U), std::pair(1U, 2U)}) {
    log += fmt::format("{}\t{}\t3\n{}\n", i, j, numbers_of(between(j, i), 4, "\n"));
    info += fmt::format("{}\t{}\t3\n", i, j);
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < 6; ++c) info += fmt::format("{} ", r != c ? 0 : r < 3 ? 1000 : 4000);
      info += '\n';
    }
  }
  write_text(root / "kitchen-evaluation/gt.log", log);
  write_text(root / "kitchen-evaluation/gt.info", info);
  write_text(root / "kitchen-evaluation/gt_overlap.log", "0,1,0.7\n0,2,0.2\n1,2,0.3\n");
}

/// A pairs.csv with two pairs of scans in folders of their own.
inline void write_pairs(const std::filesystem::path& root) {
  std::filesystem::create_directories(root / "a");
  for (std::uint32_t k = 0; k < 3; ++k) {
    write_text(root / fmt::format("a/{}.ply", k), ply_of(room(40 + k, place_of(k))));
  }
  write_text(root / "a/pose.txt", numbers_of(between(1, 0), 4, "\n") + "\n");
  write_text(root / "pairs.csv",
             fmt::format("source,target,pose,group\na/1.ply,a/0.ply,a/pose.txt,one\na/2.ply,a/1.ply,{},two\n",
                         numbers_of(between(2, 1), 3, " ")));
}

}  // namespace consimd::studies::test
