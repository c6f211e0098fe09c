#include <consimd/synth/hard_problems.hpp>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "random_stream.hpp"
#include "scenes.hpp"

namespace consimd::synth {
namespace {

constexpr std::size_t kMaxRows = std::numeric_limits<std::uint32_t>::max();

struct Row {
  Eigen::Vector3d source;
  Eigen::Vector3d target;
  bool is_inlier;
};

struct RowCounts {
  std::size_t inliers;
  std::size_t decoys;
  std::size_t outliers;  ///< that no motion explains
};

template <typename T>
void require(bool holds, std::string_view name, T value, std::string_view expected) {
  if (holds) return;
  char digits[32];
  const std::to_chars_result end = std::to_chars(std::begin(digits), std::end(digits), value);
  std::string message(name);
  message.append(" = ").append(std::string_view(digits, end.ptr)).append(": expected ").append(expected);
  throw std::invalid_argument(message);
}

void require_valid(const HardProblemOptions& o) {
  const auto finite_from = [](double low, double value) { return value >= low && std::isfinite(value); };
  const auto finite_above = [](double low, double value) { return value > low && std::isfinite(value); };
  require(o.correspondences >= 1 && o.correspondences <= kMaxRows, "correspondences", o.correspondences,
          "1 to 4294967295");
  require(o.outlier_ratio >= 0.0 && o.outlier_ratio <= 1.0, "outlier_ratio", o.outlier_ratio, "a number in [0, 1]");
  require(finite_from(0.0, o.sigma), "sigma", o.sigma, "a finite number >= 0");
  require(finite_above(0.0, o.half_extent), "half_extent", o.half_extent, "a finite number > 0");
  require(finite_from(0.0, o.thickness), "thickness", o.thickness, "a finite number >= 0");
  require(o.parts >= 1 && o.parts <= kMaxRows, "parts", o.parts, "1 to 4294967295");
  require(o.clusters >= 1 && o.clusters <= kMaxRows, "clusters", o.clusters, "1 to 4294967295");
  require(finite_from(0.0, o.cluster_sigma), "cluster_sigma", o.cluster_sigma, "a finite number >= 0");
  require(o.matches_per_point >= 2, "matches_per_point", o.matches_per_point, "at least 2");
  require(finite_from(0.0, o.decoy_share), "decoy_share", o.decoy_share, "a finite number >= 0");
  require(o.degrees_of_freedom >= 3, "degrees_of_freedom", o.degrees_of_freedom, "at least 3");
  require(finite_above(0.0, o.anisotropy), "anisotropy", o.anisotropy, "a finite number > 0");
  require(finite_from(0.0, o.quantum), "quantum", o.quantum, "a finite number >= 0");
  require(o.duplicates <= kMaxRows - o.correspondences, "duplicates", o.duplicates,
          "at most 4294967295 rows with the correspondences");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    require(std::isfinite(o.source_offset[axis]), "source_offset", o.source_offset[axis], "a finite number");
    require(std::isfinite(o.target_offset[axis]), "target_offset", o.target_offset[axis], "a finite number");
  }
  require(finite_above(0.0, o.units_per_metre), "units_per_metre", o.units_per_metre, "a finite number > 0");
  require(finite_above(0.0, o.scale), "scale", o.scale, "a finite number > 0");
}

RowCounts row_counts(const HardProblemOptions& o) {
  const auto rounded = [](double x) { return std::floor(x + 0.5); };
  const double inliers = rounded(static_cast<double>(o.correspondences) * (1.0 - o.outlier_ratio));
  const double outliers = static_cast<double>(o.correspondences) - inliers;
  const double decoys = rounded(inliers * o.decoy_share);
  require(decoys <= outliers, "decoy_share", o.decoy_share, "no more decoys than outliers");
  require(o.outliers != OutlierModel::permuted || outliers - decoys != 1.0, "outlier_ratio", o.outlier_ratio,
          "none or at least two outliers to permute");
  return {static_cast<std::size_t>(inliers), static_cast<std::size_t>(decoys),
          static_cast<std::size_t>(outliers - decoys)};
}

/// The finaliser of SplitMix64: a bijection that spreads every bit.
constexpr std::uint64_t mix(std::uint64_t x) noexcept {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

ProblemKey problem_key(const HardProblemOptions& o) noexcept {
  // Single precision, so that 0.1 + 0.1 + 0.1 and 0.3 name the same cell; + 0 makes -0 one with 0.
  const auto word = [](double x) { return std::uint64_t{std::bit_cast<std::uint32_t>(static_cast<float>(x) + 0.0f)}; };
  const std::uint64_t ratio_and_sigma = word(o.outlier_ratio) << 32 | word(o.sigma);
  return {o.seed, mix(mix(ratio_and_sigma) + o.correspondences), o.trial};
}

class Generator {
 public:
  explicit Generator(const HardProblemOptions& options)
      : options_(options),
        counts_(row_counts(options)),
        cube_(Eigen::Vector3d::Constant(options.half_extent)),
        motions_(problem_key(options), Purpose::motion),
        points_(problem_key(options), Purpose::points),
        noise_(problem_key(options), Purpose::noise),
        outliers_(problem_key(options), Purpose::outliers),
        order_(problem_key(options), Purpose::order),
        true_motion_(motion()),
        decoy_motion_(motion()),
        scene_turn_(motions_.rotation()),
        scenes_(options, motions_),
        mean_square_range_(scenes_.mean_square_range()) {
    if (options_.scene == Scene::volume) scene_turn_.setIdentity();
    if (options_.symmetric) {
      half_turn_ = scene_turn_ * Eigen::DiagonalMatrix<double, 3>(1.0, -1.0, -1.0) * scene_turn_.transpose();
      decoy_motion_ = true_motion_;
      decoy_motion_.linear() *= half_turn_;
    }
  }

  Problem generate() {
    rows_.reserve(options_.correspondences + options_.duplicates);
    for (std::size_t k = 0; k < counts_.inliers; ++k) rows_.push_back(moved(true_motion_, true));
    for (std::size_t k = 0; k < counts_.decoys; ++k) rows_.push_back(moved(decoy_motion_, false));
    add_outliers();
    for (std::size_t k = 0; k < options_.duplicates; ++k) {
      const Row copy = rows_[order_.below(static_cast<std::uint32_t>(options_.correspondences))];
      rows_.push_back(copy);
    }
    order_.shuffle(std::span(rows_));
    if (options_.mirrored) mirror();
    return finished();
  }

 private:
  RigidTransform motion() {
    RigidTransform pose = RigidTransform::Identity();
    pose.linear() = motions_.rotation();
    pose.translation() = motions_.in_box(cube_);
    return pose;
  }

  Eigen::Vector3d scene_point() {
    if (image_) return *std::exchange(image_, std::nullopt);
    last_ = scenes_.point(points_);
    Eigen::Vector3d point = scene_turn_ * last_.position;
    if (options_.symmetric) image_ = half_turn_ * point;
    return point;
  }
  Eigen::Vector3d cube_point() { return outliers_.in_box(cube_); }

  Row moved(const RigidTransform& by, bool is_inlier) {
    const Eigen::Vector3d point = scene_point();
    return {point, by * point + noise(point, by), is_inlier};
  }

  /// Of the target of a point that a motion takes there.
  Eigen::Vector3d noise(const Eigen::Vector3d& point, const RigidTransform& by) {
    const Eigen::Vector3d unit = noise_.gaussian_vector();
    switch (options_.noise) {
      case NoiseModel::range_dependent:
        return options_.sigma * std::sqrt(point.squaredNorm() / mean_square_range_) * unit;
      case NoiseModel::student_t: {
        double chi_square = 0.0;
        for (unsigned i = 0; i < options_.degrees_of_freedom; ++i) {
          const double x = noise_.gaussian();
          chi_square += x * x;
        }
        // t = unit / sqrt(chi_square / dof) has variance dof / (dof - 2).
        return options_.sigma * std::sqrt((options_.degrees_of_freedom - 2.0) / chi_square) * unit;
      }
      case NoiseModel::anisotropic: {
        // Two axes across the ray and one along it have the mean square 3 sigma^2 together.
        const double ratio = options_.anisotropy;
        const double across = options_.sigma * std::sqrt(3.0 / (2.0 + ratio * ratio));
        const Eigen::Vector3d ray = by.linear() * point.normalized();
        return across * (unit + (ratio - 1.0) * unit.dot(ray) * ray);
      }
      case NoiseModel::gaussian:
        break;
    }
    return options_.sigma * unit;
  }

  void add_outliers() {
    switch (options_.outliers) {
      case OutlierModel::uniform:
        return add_shared_sources(1);
      case OutlierModel::one_to_many:
        return add_shared_sources(options_.matches_per_point);
      case OutlierModel::permuted:
        return add_permuted();
      case OutlierModel::clustered:
        return add_clustered();
      case OutlierModel::many_to_many:
        return add_many_to_many();
      case OutlierModel::alike:
        return add_alike();
    }
  }

  void add_shared_sources(std::size_t rows_per_point) {
    Eigen::Vector3d source = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < counts_.outliers; ++k) {
      if (k % rows_per_point == 0) source = scene_point();
      rows_.push_back({source, cube_point(), false});
    }
  }

  // The points are independent, so a shift by one is as random an association as any.
  void add_permuted() {
    const std::size_t first = rows_.size();
    for (std::size_t k = 0; k < counts_.outliers; ++k) rows_.push_back(moved(true_motion_, false));
    for (std::size_t k = first; k + 1 < rows_.size(); ++k) std::swap(rows_[k].target, rows_[k + 1].target);
  }

  void add_clustered() {
    struct Centres {
      Eigen::Vector3d source, target;
    };
    std::vector<Centres> clusters(options_.clusters);
    for (Centres& cluster : clusters) cluster = {scene_point(), cube_point()};
    for (std::size_t k = 0; k < counts_.outliers; ++k) {
      const Centres& cluster = clusters[outliers_.below(static_cast<std::uint32_t>(clusters.size()))];
      const Eigen::Vector3d source = cluster.source + options_.cluster_sigma * outliers_.gaussian_vector();
      const Eigen::Vector3d target = cluster.target + options_.cluster_sigma * outliers_.gaussian_vector();
      rows_.push_back({source, target, false});
    }
  }

  // Features on a ring; wrong pairs join a feature to those 1, 2, ... places on, one step length after the other. So a
  // point has at most one wrong pair per step length, beside its true one.
  void add_many_to_many() {
    const std::size_t wrong_per_point = options_.matches_per_point - 1;
    const std::size_t needed = (counts_.outliers + wrong_per_point - 1) / wrong_per_point;
    std::vector<Row> features(rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(counts_.inliers));
    // More features than steps, so that no pair comes twice and none is a feature with itself.
    const std::size_t distinct = std::min(options_.matches_per_point, counts_.outliers + 1);
    while (features.size() < std::max(needed, distinct)) features.push_back(moved(true_motion_, false));
    for (std::size_t k = 0; k < counts_.outliers; ++k) {
      const std::size_t from = k % features.size(), step = 1 + k / features.size();
      rows_.push_back({features[from].source, features[(from + step) % features.size()].target, false});
    }
  }

  void add_alike() {
    for (std::size_t k = 0; k < counts_.outliers; ++k) {
      const Eigen::Vector3d source = scene_point();
      const Eigen::Vector3d like = scene_turn_ * scenes_.alike(last_, outliers_);
      rows_.push_back({source, decoy_motion_ * like + noise(like, decoy_motion_), false});
    }
  }

  // x -> -x in the source makes the motion that maps it to the target a reflection.
  void mirror() {
    for (Row& row : rows_) {
      row.source.x() = -row.source.x();
      row.is_inlier = false;
    }
  }

  Problem finished() const {
    const Eigen::Map<const Eigen::Vector3d> source_offset(options_.source_offset.data());
    const Eigen::Map<const Eigen::Vector3d> target_offset(options_.target_offset.data());
    Problem problem;
    problem.source.reserve(3 * rows_.size());
    problem.target.reserve(3 * rows_.size());
    problem.is_inlier.reserve(rows_.size());
    for (const Row& row : rows_) {
      append(problem.source, row.source, source_offset, options_.scale);
      append(problem.target, row.target, target_offset, 1.0);
      problem.is_inlier.push_back(row.is_inlier ? 1 : 0);
    }
    const auto in_frame_of_rows = [&](RigidTransform pose) {
      pose.translation() =
          options_.units_per_metre * (pose.translation() + target_offset - pose.linear() * source_offset);
      return pose;
    };
    problem.T_target_source = in_frame_of_rows(true_motion_);
    problem.decoy_T_target_source = in_frame_of_rows(decoy_motion_);
    problem.scale = options_.scale;
    problem.sigma = options_.units_per_metre * options_.sigma;
    require_finite(problem);
    return problem;
  }

  /// Options that are in range alone may together lead out of a double's range.
  void require_finite(const Problem& problem) const {
    const auto finite = [](const auto& values) {
      return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
    };
    if (finite(problem.source) && finite(problem.target) && problem.T_target_source.matrix().allFinite()) return;
    throw std::invalid_argument(
        "sigma, scale, units_per_metre, half_extent and offsets: expected values of which the "
        "coordinates are finite numbers");
  }

  void append(std::vector<double>& cloud, const Eigen::Vector3d& point, const Eigen::Vector3d& offset,
              double divisor) const {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      double x = point[axis];
      if (options_.quantum > 0.0) x = options_.quantum * std::round(x / options_.quantum);
      cloud.push_back(options_.units_per_metre * (x + offset[axis]) / divisor);
    }
  }

  const HardProblemOptions& options_;
  RowCounts counts_;
  Eigen::Vector3d cube_;  ///< half extents
  RandomStream motions_, points_, noise_, outliers_, order_;
  RigidTransform true_motion_, decoy_motion_;
  Eigen::Matrix3d scene_turn_;
  ScenePair scenes_;
  double mean_square_range_;
  ScenePair::Point last_;                                    ///< drawn of the scene, before the turn
  Eigen::Matrix3d half_turn_ = Eigen::Matrix3d::Identity();  ///< that maps a symmetric scene to itself
  std::optional<Eigen::Vector3d> image_;                     ///< of the last scene point, if it is the next one
  std::vector<Row> rows_;
};

}  // namespace

Problem hard_problem(const HardProblemOptions& options) {
  require_valid(options);
  return Generator(options).generate();
}

}  // namespace consimd::synth
