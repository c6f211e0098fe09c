// Problems with a known truth, brute-force geometry in double, and what every registration must satisfy.
#pragma once

#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/problem.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace consimd::test {

using synth::Problem;

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr std::array kBadLengths{0.0, -1.5, kNan, kInfinity, -kInfinity};
inline constexpr std::array kBadConfidences{0.0, 1.0, -0.5, 1.5, kNan};

/// The solvers that take in turn what holds for each of them.
inline constexpr std::array kSolvers{"tcf", "ransac", "sc2_pcr", "turboreg", "pcr99", "teaser", "mac"};

/// Trials of a long test: a twentieth of `count` under the sanitizers, which make the solvers some fifteen times
/// slower.
constexpr std::uint64_t trials(std::uint64_t count) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return std::max<std::uint64_t>(count / 20, 1);
#else
  return count;
#endif
}

/// Whether a long test has trials enough for its means to be held against limits.
inline constexpr bool kAllTrials = trials(20) == 20;

inline Eigen::Vector3d source_point(const Problem& problem, std::size_t k) {
  return Eigen::Vector3d(&problem.source[3 * k]);
}
inline Eigen::Vector3d target_point(const Problem& problem, std::size_t k) {
  return Eigen::Vector3d(&problem.target[3 * k]);
}

inline double residual(const Problem& problem, const RigidTransform& T_target_source, std::size_t k) {
  return (T_target_source * source_point(problem, k) - target_point(problem, k)).norm();
}

/// Root mean square distance between the places that two poses take the sources to.
inline double displacement(const Problem& problem, const RigidTransform& a, const RigidTransform& b) {
  double squares = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    squares += (a * source_point(problem, k) - b * source_point(problem, k)).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(problem.size()));
}

/// Whether a pose takes the true inliers to within twice the noise bound, root mean square.
inline bool is_right(const Problem& problem, const Registration& result, double noise_bound) {
  return result.has_pose() &&
         synth::rmse_true_inliers(problem, result.T_target_source, result.scale) < 2.0 * noise_bound;
}

/// | |p_j - p_k| - |q_j - q_k| |
inline double length_difference(const Problem& problem, std::size_t j, std::size_t k) {
  return std::abs((source_point(problem, j) - source_point(problem, k)).norm() -
                  (target_point(problem, j) - target_point(problem, k)).norm());
}

/// What single precision may make of a length in the frame of these correspondences, caller's unit.
inline double rounding(const Correspondences& correspondences) { return 1e-6 / correspondences.scale(); }

inline std::vector<std::uint32_t> all_rows(const Problem& problem) {
  std::vector<std::uint32_t> rows(problem.size());
  std::iota(rows.begin(), rows.end(), 0U);
  return rows;
}

inline std::vector<std::uint32_t> true_inliers(const Problem& problem) {
  std::vector<std::uint32_t> rows = all_rows(problem);
  std::erase_if(rows, [&](std::uint32_t k) { return problem.is_inlier[k] == 0; });
  return rows;
}

/// 0 .. size - 1 in an order that is the same on every platform.
inline std::vector<std::uint32_t> random_order(std::size_t size, std::uint32_t seed) {
  std::vector<std::uint32_t> order(size);
  std::iota(order.begin(), order.end(), 0U);
  std::mt19937 random(seed);
  for (std::size_t i = size; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  return order;
}

/// Row k of the result is row rows[k] of `problem`.
inline Problem chosen_rows(const Problem& problem, std::span<const std::uint32_t> rows) {
  Problem chosen;
  chosen.T_target_source = problem.T_target_source;
  chosen.sigma = problem.sigma;
  for (const std::size_t k : rows) {
    chosen.source.insert(chosen.source.end(), &problem.source[3 * k], &problem.source[3 * k] + 3);
    chosen.target.insert(chosen.target.end(), &problem.target[3 * k], &problem.target[3 * k] + 3);
    chosen.is_inlier.push_back(problem.is_inlier[k]);
  }
  return chosen;
}

/// The target cloud moved by `motion`, and the truth with it.
inline Problem with_moved_target(Problem problem, const RigidTransform& motion) {
  for (std::size_t k = 0; k < problem.size(); ++k) {
    Eigen::Map<Eigen::Vector3d>(&problem.target[3 * k]) = motion * target_point(problem, k);
  }
  problem.T_target_source = motion * problem.T_target_source;
  return problem;
}

/// The problem in another unit, `factor` of them to one of the old.
inline Problem in_units(Problem problem, double factor) {
  for (double& x : problem.source) x *= factor;
  for (double& x : problem.target) x *= factor;
  problem.T_target_source.translation() *= factor;
  problem.sigma *= factor;
  return problem;
}

inline RigidTransform motion(double angle_rad, const Eigen::Vector3d& axis, const Eigen::Vector3d& translation) {
  RigidTransform T = RigidTransform::Identity();
  T.linear() = Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
  T.translation() = translation;
  return T;
}

inline RigidTransform random_motion(std::mt19937& random) {
  const auto uniform = [&] { return static_cast<double>(static_cast<std::int32_t>(random())) * 0x1p-31; };
  const Eigen::Vector3d axis(uniform(), uniform(), uniform());
  const double angle = 3.1 * uniform();
  return motion(angle, axis, 100.0 * Eigen::Vector3d(uniform(), uniform(), uniform()));
}

/// `points` under `truth` without noise, all of them inliers.
inline Problem perfect_problem(std::span<const Eigen::Vector3d> points, const RigidTransform& truth) {
  Problem problem;
  problem.T_target_source = truth;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d q = truth * p;
    problem.source.insert(problem.source.end(), p.data(), p.data() + 3);
    problem.target.insert(problem.target.end(), q.data(), q.data() + 3);
    problem.is_inlier.push_back(1);
  }
  return problem;
}

/// Errors of several trials, and the oracle's on the same data.
struct Errors {
  double rotation = 0.0;
  double translation = 0.0;
  double oracle_rotation = 0.0;
  double oracle_translation = 0.0;

  void add(const Problem& problem, const RigidTransform& T) {
    const RigidTransform oracle = synth::oracle(problem);
    rotation += synth::rotation_error_deg(T, problem.T_target_source);
    translation += synth::translation_error(T, problem.T_target_source);
    oracle_rotation += synth::rotation_error_deg(oracle, problem.T_target_source);
    oracle_translation += synth::translation_error(oracle, problem.T_target_source);
  }

  void expect_within(double ratio) const {
    EXPECT_LT(rotation, ratio * oracle_rotation);
    EXPECT_LT(translation, ratio * oracle_translation);
  }
};

inline void expect_proper_rotation(const RigidTransform& T) {
  ASSERT_TRUE(T.matrix().allFinite()) << T.matrix();
  EXPECT_LT((T.linear().transpose() * T.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-9) << T.matrix();
  EXPECT_NEAR(T.linear().determinant(), 1.0, 1e-9) << T.matrix();
}

/// `rows` are strictly ascending and exactly those within `bound` of the pose; single precision decides on the border.
inline void expect_rows_within(std::span<const std::uint32_t> rows, const Problem& problem, const RigidTransform& T,
                               double bound) {
  const double border = rounding(problem.correspondences());
  EXPECT_TRUE(std::ranges::is_sorted(rows, std::ranges::less_equal{}));
  for (std::uint32_t k = 0; k < problem.size(); ++k) {
    const double r = residual(problem, T, k);
    if (std::abs(r - bound) <= border) continue;
    EXPECT_EQ(std::ranges::binary_search(rows, k), r < bound) << "row " << k << " with residual " << r;
  }
}

/// `runner_up` is a pose, and its support the number of rows within the bound; single precision decides on the border.
inline void expect_sound(const RunnerUp& runner_up, const Problem& problem, double noise_bound) {
  expect_proper_rotation(runner_up.T_target_source);
  const double border = rounding(problem.correspondences());
  std::size_t inside = 0;
  std::size_t near_border = 0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double r = residual(problem, runner_up.T_target_source, k);
    if (std::abs(r - noise_bound) <= border) {
      ++near_border;
    } else if (r < noise_bound) {
      ++inside;
    }
  }
  EXPECT_GE(runner_up.support, std::max<std::size_t>(inside, 3));
  EXPECT_LE(runner_up.support, inside + near_border);
  EXPECT_TRUE(std::isfinite(runner_up.log10_false_poses)) << runner_up.log10_false_poses;
}

/// What holds for every registration, whatever the data.
inline void expect_sound(const Registration& result, const Problem& problem, double noise_bound) {
  SCOPED_TRACE(::testing::Message() << "status " << to_string(result.status));
  expect_proper_rotation(result.T_target_source);
  EXPECT_EQ(result.T_target_source.matrix().row(3), Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0));
  if (result.has_pose()) {
    EXPECT_GE(result.inliers.size(), 3u);
    expect_rows_within(result.inliers, problem, result.T_target_source, result.noise_bound);
  } else {
    EXPECT_EQ(result.T_target_source.matrix(), Eigen::Matrix4d::Identity());
    EXPECT_TRUE(result.covariance.isZero(0.0)) << result.covariance;
    EXPECT_TRUE(result.inliers.empty());
    EXPECT_FALSE(result.runner_up);
  }
  EXPECT_TRUE(result.runner_up || result.status != Status::ambiguous);
  if (result.runner_up) expect_sound(*result.runner_up, problem, result.noise_bound);
  EXPECT_TRUE(std::isfinite(result.log10_false_poses)) << result.log10_false_poses;
  EXPECT_TRUE(result.covariance.allFinite()) << result.covariance;
  EXPECT_EQ(result.covariance, result.covariance.transpose());
  EXPECT_EQ(result.noise_bound_asked, noise_bound);
  EXPECT_EQ(result.noise_bound, std::max(noise_bound, problem.correspondences().resolution()));
  EXPECT_EQ(result.consistency_bound, 2.0 * result.noise_bound);
  EXPECT_EQ(result.isa, active_isa());
  EXPECT_GE(result.threads, 1);
  EXPECT_GE(result.seconds, 0.0);
  // Copies of one row or two are degenerate, and no stage has to look at them.
  EXPECT_TRUE(!result.stages.empty() || result.status == Status::too_few_correspondences ||
              result.status == Status::degenerate_geometry);
  EXPECT_TRUE(result.stages.empty() || result.status != Status::too_few_correspondences);
  double seconds = 0.0;
  for (const StageReport& stage : result.stages) {
    EXPECT_FALSE(stage.name.empty());
    EXPECT_LE(stage.input, problem.size()) << stage.name;
    EXPECT_LE(stage.output, problem.size()) << stage.name;
    EXPECT_GE(stage.seconds, 0.0) << stage.name;
    seconds += stage.seconds;
  }
  EXPECT_LE(seconds, result.seconds);
}

/// `call` must throw std::invalid_argument that names the option and its value.
template <typename Call>
void expect_rejected(Call call, const std::string& option, double value) {
  std::ostringstream text;
  text << value;
  try {
    call();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(option), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(text.str()), std::string::npos) << error.what();
    return;
  }
  ADD_FAILURE() << option << " = " << value << " was accepted";
}

}  // namespace consimd::test
