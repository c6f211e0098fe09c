#include <consimd/synth/field_problems.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "random_stream.hpp"

namespace consimd::synth {
namespace {

// Apart from the cells of other generators, and from one another.
enum class Kind : std::uint64_t { far_rows = 0x6669656C64, no_depth, repeated_targets, all_to_all, symmetric_part };

struct Row {
  Eigen::Vector3d source;
  Eigen::Vector3d target;
  bool is_inlier;
};

void require_count(const char* name, std::size_t value, std::size_t low, std::size_t end) {
  if (value >= low && value < end) return;
  throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) + ": expected " + std::to_string(low) +
                              " to " + std::to_string(end - 1));
}

void require_number(const char* name, double value, bool holds, const char* expected) {
  if (holds && std::isfinite(value)) return;
  throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) + ": expected " + expected);
}

void require_lengths(double sigma, double half_extent) {
  require_number("sigma", sigma, sigma >= 0.0, "a finite number >= 0");
  require_number("half_extent", half_extent, half_extent > 0.0, "a finite number > 0");
}

void require_share(const char* name, double value) {
  require_number(name, value, value >= 0.0 && value <= 1.0, "a number in [0, 1]");
}

// All that a kind of problem draws from.
struct Streams {
  Streams(Kind kind, std::size_t size, std::uint64_t seed, std::uint64_t trial)
      : key{seed, (static_cast<std::uint64_t>(kind) << 32) + size, trial},
        motions(key, Purpose::motion),
        points(key, Purpose::points),
        noise(key, Purpose::noise),
        outliers(key, Purpose::outliers),
        order(key, Purpose::order) {}

  RigidTransform motion(double half_extent) {
    RigidTransform pose = RigidTransform::Identity();
    pose.linear() = motions.rotation();
    pose.translation() = motions.in_box(Eigen::Vector3d::Constant(half_extent));
    return pose;
  }

  ProblemKey key;
  RandomStream motions, points, noise, outliers, order;
};

// The rows in random order.
Problem problem_of(std::vector<Row> rows, const RigidTransform& motion, double sigma, RandomStream& order) {
  order.shuffle(std::span(rows));
  Problem problem;
  problem.T_target_source = motion;
  problem.sigma = sigma;
  for (const Row& row : rows) {
    problem.source.insert(problem.source.end(), row.source.begin(), row.source.end());
    problem.target.insert(problem.target.end(), row.target.begin(), row.target.end());
    problem.is_inlier.push_back(row.is_inlier ? 1 : 0);
  }
  return problem;
}

Eigen::Vector3d point(const std::vector<double>& cloud, std::size_t k) { return Eigen::Vector3d(&cloud[3 * k]); }

// The problem with outliers more; those of the problem keep their order.
Problem mixed(const Problem& problem, const std::vector<Row>& more, RandomStream& order) {
  std::vector<std::uint8_t> is_new(problem.size() + more.size(), 0);
  std::fill(is_new.begin() + static_cast<std::ptrdiff_t>(problem.size()), is_new.end(), std::uint8_t{1});
  order.shuffle(std::span(is_new));
  Problem result = problem;
  result.source.clear();
  result.target.clear();
  result.is_inlier.clear();
  std::size_t old_row = 0;
  std::size_t new_row = 0;
  for (const std::uint8_t from_more : is_new) {
    const Row row = from_more != 0 ? more[new_row++]
                                   : Row{point(problem.source, old_row), point(problem.target, old_row),
                                         problem.is_inlier[old_row] != 0};
    if (from_more == 0) ++old_row;
    result.source.insert(result.source.end(), row.source.begin(), row.source.end());
    result.target.insert(result.target.end(), row.target.begin(), row.target.end());
    result.is_inlier.push_back(row.is_inlier ? 1 : 0);
  }
  return result;
}

}  // namespace

Problem with_far_rows(const Problem& problem, const FarRowOptions& o) {
  require_count("rows", o.rows, 0, std::size_t{1} << 31U);
  require_number("distance", o.distance, o.distance > 0.0, "a finite number > 0");
  if (problem.size() == 0) throw std::invalid_argument("problem: has no rows, expected at least one");
  Streams streams(Kind::far_rows, o.rows, o.seed, o.trial);
  const auto far_point = [&] {
    const Eigen::Vector3d direction = streams.outliers.gaussian_vector().normalized();
    return Eigen::Vector3d(streams.outliers.uniform(0.1, 1.0) * o.distance * direction);
  };
  const auto near_point = [&](const std::vector<double>& cloud) {
    return point(cloud, streams.points.below(static_cast<std::uint32_t>(problem.size())));
  };
  const std::pair<Eigen::Vector3d, Eigen::Vector3d> place{far_point(), far_point()};
  std::vector<Row> rows;
  for (std::size_t k = 0; k < o.rows; ++k) {
    Row row{near_point(problem.source), near_point(problem.target), false};
    if (o.side != FarSide::target) row.source = o.coincident ? place.first : far_point();
    if (o.side != FarSide::source) row.target = o.coincident ? place.second : far_point();
    rows.push_back(row);
  }
  return mixed(problem, rows, streams.order);
}

Problem with_rows_without_depth(const Problem& problem, std::size_t rows, std::uint64_t seed, std::uint64_t trial) {
  require_count("rows", rows, 0, std::size_t{1} << 31U);
  Streams streams(Kind::no_depth, rows, seed, trial);
  return mixed(problem, std::vector<Row>(rows, {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), false}),
               streams.order);
}

Problem repeated_targets(const RepeatedTargetOptions& o) {
  require_count("targets", o.targets, 3, std::size_t{1} << 16U);
  require_count("frames", o.frames, 1, std::size_t{1} << 15U);
  require_share("blunders", o.blunders);
  require_lengths(o.sigma, o.half_extent);
  Streams streams(Kind::repeated_targets, o.targets, o.seed, o.trial);
  const RigidTransform motion = streams.motion(o.half_extent);
  const Eigen::Vector3d cube = Eigen::Vector3d::Constant(o.half_extent);
  const auto wrong = static_cast<std::size_t>(std::floor(o.blunders * static_cast<double>(o.targets) + 0.5));
  std::vector<Row> rows;
  for (std::size_t k = 0; k < o.targets; ++k) {
    const bool is_inlier = k >= wrong;
    const Eigen::Vector3d source = streams.points.in_box(cube);
    const Eigen::Vector3d target = motion * (is_inlier ? source : streams.outliers.in_box(cube));
    const auto measured = [&] {
      const Eigen::Vector3d seen_source = source + o.sigma * streams.noise.gaussian_vector();
      return Row{seen_source, target + o.sigma * streams.noise.gaussian_vector(), is_inlier};
    };
    const Row once = measured();
    for (std::size_t frame = 0; frame < o.frames; ++frame) {
      rows.push_back(frame == 0 || o.copied ? once : measured());
    }
  }
  return problem_of(std::move(rows), motion, std::numbers::sqrt2 * o.sigma, streams.order);
}

Problem all_to_all(const AllToAllOptions& o) {
  require_count("landmarks", o.landmarks, 3, std::size_t{1} << 11U);
  require_share("missing", o.missing);
  require_lengths(o.sigma, o.half_extent);
  Streams streams(Kind::all_to_all, o.landmarks, o.seed, o.trial);
  const RigidTransform motion = streams.motion(o.half_extent);
  const Eigen::Vector3d cube = Eigen::Vector3d::Constant(o.half_extent);
  const auto missing = static_cast<std::size_t>(std::floor(o.missing * static_cast<double>(o.landmarks) + 0.5));
  std::vector<Row> landmarks;
  for (std::size_t k = 0; k < o.landmarks; ++k) {
    const Eigen::Vector3d source = streams.points.in_box(cube);
    const Eigen::Vector3d place = k < missing ? streams.outliers.in_box(cube) : source;
    landmarks.push_back({source, motion * place + o.sigma * streams.noise.gaussian_vector(), k >= missing});
  }
  std::vector<Row> rows;
  for (const Row& from : landmarks) {
    for (const Row& to : landmarks) rows.push_back({from.source, to.target, from.is_inlier && &from == &to});
  }
  return problem_of(std::move(rows), motion, o.sigma, streams.order);
}

Problem symmetric_part(const SymmetricPartOptions& o) {
  require_count("folds", o.folds, 2, std::size_t{1} << 10U);
  require_count("points_per_sector", o.points_per_sector, 3, std::size_t{1} << 16U);
  require_lengths(o.sigma, o.half_extent);
  Streams streams(Kind::symmetric_part, o.folds * o.points_per_sector, o.seed, o.trial);
  const RigidTransform motion = streams.motion(o.half_extent);
  const Eigen::Matrix3d axes = streams.motions.rotation();
  const auto turn = [&](std::size_t fold) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(fold) / static_cast<double>(o.folds);
    return Eigen::Matrix3d(axes * turn_about(Eigen::Vector3d::UnitZ(), angle).toRotationMatrix() * axes.transpose());
  };
  std::vector<Row> rows;
  for (std::size_t k = 0; k < o.points_per_sector; ++k) {
    const Eigen::Vector3d first = streams.points.in_box(Eigen::Vector3d::Constant(o.half_extent));
    std::vector<Eigen::Vector3d> targets;
    targets.reserve(o.folds);
    for (std::size_t fold = 0; fold < o.folds; ++fold) {
      targets.emplace_back(motion * (turn(fold) * first) + o.sigma * streams.noise.gaussian_vector());
    }
    for (std::size_t from = 0; from < o.folds; ++from) {
      for (std::size_t to = 0; to < o.folds; ++to) rows.push_back({turn(from) * first, targets[to], from == to});
    }
  }
  Problem problem = problem_of(std::move(rows), motion, o.sigma, streams.order);
  problem.decoy_T_target_source = motion;
  problem.decoy_T_target_source.linear() = motion.linear() * turn(1);
  return problem;
}

}  // namespace consimd::synth
