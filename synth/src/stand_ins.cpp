#include <consimd/synth/stand_ins.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "mutual_matches.hpp"
#include "random_stream.hpp"
#include "scanned_surfaces.hpp"

namespace consimd::synth {
namespace {

using Eigen::Vector3d;

constexpr StandIn kStandIns[] = {
    {"arch", "ETH", "Arch", ScannedScene::arch, 16.48, 6989, 0.011, 0.3, 0.2},
    {"courtyard", "ETH", "Courtyard", ScannedScene::courtyard, 16.63, 9910, 0.061, 0.3, 0.2},
    {"facade", "ETH", "Facade", ScannedScene::facade, 4.06, 2250, 0.122, 0.3, 0.2},
    {"office", "ETH", "Office", ScannedScene::office, 7.49, 2964, 0.056, 0.3, 0.2},
    {"trees", "ETH", "Trees", ScannedScene::trees, 10.64, 8242, 0.012, 0.3, 0.2},
    {"kitti01", "KITTI", "01", ScannedScene::highway, 16.97, 3343, 0.024, 0.6, 0.6},
    {"kitti02", "KITTI", "02", ScannedScene::mixed, 16.97, 3104, 0.035, 0.6, 0.6},
    {"kitti03", "KITTI", "03", ScannedScene::country, 17.02, 3175, 0.046, 0.6, 0.6},
    {"kitti06", "KITTI", "06", ScannedScene::urban, 16.95, 3655, 0.036, 0.6, 0.6},
    {"kitti09", "KITTI", "09", ScannedScene::mixed, 16.96, 3042, 0.038, 0.6, 0.6},
};

// Half widths of the uniform scatter of a pair's numbers.
constexpr double kDistanceScatter = 0.2;
constexpr double kSizeScatter = 0.3;
constexpr double kRatioScatter = 0.6;

/// What tells a terrestrial scanner from one on a car. Lengths in metres, angles in degrees.
struct Sensor {
  double range;          ///< in a room all is nearer
  double height;         ///< above the ground
  double tilt;           ///< deviation about each horizontal axis
  double largest_turn;   ///< about the vertical, from one scan to the next
  double along_surface;  ///< deviation per tangent of where a keypoint is found again
  double across_surface;
};

constexpr Sensor kTripod{60.0, 1.6, 0.5, 40.0, 0.13, 0.02};
constexpr Sensor kCar{55.0, 1.7, 0.5, 12.0, 0.35, 0.06};

// Keypoints of a scan that are matched at once, and how often, at most, until the rows suffice.
constexpr std::size_t kKeypoints = 2000;
constexpr int kMostBatches = 1000;
constexpr std::size_t kMatchesPerPoint = 3;
// Keypoints that both scans see, per valid match wanted: most are crowded out by places that look alike.
constexpr double kSharedPerInlier = 4.0;
constexpr double kMostShared = 0.8;
// Deviations of a descriptor: what a place has of its own, and what the second scan changes of that.
constexpr double kOwnLook = 0.2;
constexpr double kLookNoise = 0.04;
constexpr double kFoliageOwnLook = 1.0;
constexpr double kFoliageLookNoise = 0.25;

/// FNV-1a.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

double scattered(RandomStream& random, double mean, double scatter) {
  return mean * random.uniform(1.0 - scatter, 1.0 + scatter);
}

struct Row {
  Vector3d source, target;
  bool is_inlier;
};

class ScanPair {
 public:
  ScanPair(const StandIn& stand_in, const ProblemKey& key)
      : stand_in_(stand_in),
        sensor_(stand_in.dataset == "ETH" ? kTripod : kCar),
        motions_(key, Purpose::motion),
        points_(key, Purpose::points),
        noise_(key, Purpose::noise),
        order_(key, Purpose::order),
        surfaces_(scanned_scene(stand_in.scene, points_)) {
    double area = 0.0;
    for (const Surface& surface : surfaces_) areas_.push_back(area += surface.area());
    place_scanners();
    const double size = scattered(motions_, static_cast<double>(stand_in.correspondences), kSizeScatter);
    rows_wanted_ = static_cast<std::size_t>(std::lround(size));
    const double inliers = size * scattered(motions_, stand_in.inlier_ratio, kRatioScatter);
    inliers_wanted_ = static_cast<std::size_t>(std::lround(inliers));
  }

  Problem generate() {
    std::vector<Row> inliers, outliers;
    const std::size_t outliers_wanted = rows_wanted_ - inliers_wanted_;
    for (int batch = 0; inliers.size() < inliers_wanted_ || outliers.size() < outliers_wanted; ++batch) {
      if (batch == kMostBatches) throw std::logic_error("the scene of a stand-in gives too few matches");
      std::vector<Row> rows = matched_keypoints();
      order_.shuffle(std::span(rows));
      for (const Row& row : rows) {
        if (row.is_inlier && inliers.size() < inliers_wanted_) inliers.push_back(row);
        if (!row.is_inlier && outliers.size() < outliers_wanted) outliers.push_back(row);
      }
    }
    outliers.insert(outliers.end(), inliers.begin(), inliers.end());
    order_.shuffle(std::span(outliers));
    return finished(outliers);
  }

 private:
  struct Keypoint {
    Vector3d position;  // scene frame
    Descriptor descriptor;
  };

  // T_scene_scanner of both; the target's turned against the source's.
  void place_scanners() {
    const double distance = scattered(motions_, stand_in_.pair_distance, kDistanceScatter);
    const double heading = motions_.uniform(0.0, 2.0 * std::numbers::pi);
    const double turn = motions_.uniform(-sensor_.largest_turn, sensor_.largest_turn) * std::numbers::pi / 180.0;
    source_scanner_ = scanner(-0.5 * distance, heading);
    target_scanner_ = scanner(0.5 * distance, heading + turn);
  }

  RigidTransform scanner(double x, double heading) {
    const double degree = std::numbers::pi / 180.0;
    const double roll = sensor_.tilt * degree * motions_.gaussian();
    const double pitch = sensor_.tilt * degree * motions_.gaussian();
    RigidTransform pose = RigidTransform::Identity();
    pose.linear() = (turn_about(Vector3d::UnitZ(), heading) * turn_about(Vector3d::UnitY(), pitch) *
                     turn_about(Vector3d::UnitX(), roll))
                        .toRotationMatrix();
    pose.translation() = Vector3d(x, 0.0, sensor_.height);
    return pose;
  }

  bool sees(const RigidTransform& scanner, const Vector3d& point) const {
    return (point - scanner.translation()).squaredNorm() < sensor_.range * sensor_.range;
  }

  const Surface& any_surface() {
    const double area = points_.uniform(0.0, areas_.back());
    const auto found = std::ranges::upper_bound(areas_, area);
    return surfaces_[std::min(static_cast<std::size_t>(found - areas_.begin()), surfaces_.size() - 1)];
  }

  Keypoint keypoint(const Surface& surface, const Vector3d& position, double own_look) {
    const Look look = surface.look(position);
    const bool foliage = look.kind == SurfaceKind::foliage;
    const double noise = foliage ? kFoliageLookNoise : kLookNoise;
    const auto seen = [&](double x) { return static_cast<float>(x + noise * noise_.gaussian()); };
    const double own = (foliage ? kFoliageOwnLook : kOwnLook) * own_look;
    return {position, {static_cast<std::uint8_t>(look.kind), {seen(look.across), seen(look.up), seen(own)}}};
  }

  // Keypoints of one scan alone, in its range.
  void add_private(const RigidTransform& scanner, std::vector<Keypoint>& keypoints) {
    while (keypoints.size() < kKeypoints) {
      const Surface& surface = any_surface();
      const Vector3d position = surface.sample(points_).position;
      const double own_look = points_.gaussian();
      if (sees(scanner, position)) keypoints.push_back(keypoint(surface, position, own_look));
    }
  }

  // Keypoints of both scans: in the second they are found some way along the surface.
  void add_shared(std::vector<Keypoint>& source, std::vector<Keypoint>& target) {
    const double share = kSharedPerInlier * static_cast<double>(inliers_wanted_) / static_cast<double>(rows_wanted_);
    const auto wanted = static_cast<std::size_t>(std::min(share, kMostShared) * kKeypoints);
    while (source.size() < wanted) {
      const Surface& surface = any_surface();
      const SurfacePoint point = surface.sample(points_);
      const double own_look = points_.gaussian();
      const Vector3d shift = noise_.gaussian_vector();
      const Vector3d again = point.position +
                             sensor_.along_surface * (shift.x() * point.tangent + shift.y() * point.other) +
                             sensor_.across_surface * shift.z() * point.normal;
      if (!sees(source_scanner_, point.position) || !sees(target_scanner_, again)) continue;
      source.push_back(keypoint(surface, point.position, own_look));
      target.push_back(keypoint(surface, again, own_look));
    }
  }

  std::vector<Row> matched_keypoints() {
    std::vector<Keypoint> source, target;
    add_shared(source, target);
    add_private(source_scanner_, source);
    add_private(target_scanner_, target);
    const auto descriptors = [](const std::vector<Keypoint>& keypoints) {
      std::vector<Descriptor> result;
      result.reserve(keypoints.size());
      for (const Keypoint& keypoint : keypoints) result.push_back(keypoint.descriptor);
      return result;
    };
    const RigidTransform from_scene = source_scanner_.inverse(), to_target = target_scanner_.inverse();
    std::vector<Row> rows;
    for (const Match& match : mutual_matches(descriptors(source), descriptors(target), kMatchesPerPoint)) {
      const Vector3d& p = source[match.source].position;
      const Vector3d& q = target[match.target].position;
      rows.push_back({from_scene * p, to_target * q, (p - q).norm() <= stand_in_.inlier_distance});
    }
    return rows;
  }

  Problem finished(const std::vector<Row>& rows) const {
    Problem problem;
    problem.T_target_source = target_scanner_.inverse() * source_scanner_;
    double squares = 0.0;
    for (const Row& row : rows) {
      problem.source.insert(problem.source.end(), row.source.data(), row.source.data() + 3);
      problem.target.insert(problem.target.end(), row.target.data(), row.target.data() + 3);
      problem.is_inlier.push_back(row.is_inlier ? 1 : 0);
      if (row.is_inlier) squares += (problem.T_target_source * row.source - row.target).squaredNorm();
    }
    problem.sigma = std::sqrt(squares / (3.0 * static_cast<double>(std::max<std::size_t>(inliers_wanted_, 1))));
    return problem;
  }

  const StandIn& stand_in_;
  const Sensor& sensor_;
  RandomStream motions_, points_, noise_, order_;
  std::vector<Surface> surfaces_;
  std::vector<double> areas_;  // of the surfaces, added up
  RigidTransform source_scanner_, target_scanner_;
  std::size_t rows_wanted_ = 0;
  std::size_t inliers_wanted_ = 0;
};

}  // namespace

std::span<const StandIn> stand_ins() noexcept { return kStandIns; }

const StandIn& stand_in(std::string_view name) {
  std::string known;
  for (const StandIn& candidate : kStandIns) {
    if (candidate.name == name) return candidate;
    known.append(known.empty() ? "" : ", ").append(candidate.name);
  }
  throw std::invalid_argument("stand-in is '" + std::string(name) + "', expected one of: " + known);
}

Problem stand_in_problem(const StandIn& stand_in, std::uint64_t seed, std::uint64_t trial) {
  return ScanPair(stand_in, {seed, hash_of(stand_in.name), trial}).generate();
}

}  // namespace consimd::synth
