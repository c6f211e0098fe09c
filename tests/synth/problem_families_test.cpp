#include <consimd/synth/problem_families.hpp>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/metrics.hpp>

namespace consimd::synth {
namespace {

constexpr std::size_t kRows = 2000;
constexpr double kSigma = 0.5;

Problem problem_of(std::string_view family, double ratio, std::uint64_t trial = 0) {
  return family_problem(family,
                        {.correspondences = kRows, .outlier_ratio = ratio, .sigma = kSigma, .seed = 3, .trial = trial});
}

Eigen::Vector3d row(const std::vector<double>& cloud, std::size_t k) { return Eigen::Vector3d(&cloud[3 * k]); }

/// Of the true inliers under the true motion, each with its source point.
struct Residual {
  Eigen::Vector3d source, error;
};
std::vector<Residual> residuals(const Problem& problem) {
  std::vector<Residual> all;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    if (problem.is_inlier[k] == 0) continue;
    const Eigen::Vector3d source = row(problem.source, k);
    all.push_back({source, row(problem.target, k) - problem.T_target_source * (problem.scale * source)});
  }
  return all;
}

double deviation_per_axis(const std::vector<Residual>& all) {
  double squares = 0.0;
  for (const Residual& one : all) squares += one.error.squaredNorm();
  return std::sqrt(squares / (3.0 * static_cast<double>(all.size())));
}

/// Share of the residuals within so many sigma.
double share_within(const std::vector<Residual>& all, double sigmas) {
  double count = 0.0;
  for (const Residual& one : all) count += one.error.norm() < sigmas * kSigma;
  return count / static_cast<double>(all.size());
}

using Cell = std::tuple<std::string, double>;
class Families : public testing::TestWithParam<Cell> {};

TEST_P(Families, HaveTheirShareOfOutliersAndTheirNoise) {
  const auto& [name, ratio] = GetParam();
  const Problem problem = problem_of(name, ratio);
  ASSERT_EQ(problem.size(), kRows);
  const std::vector<Residual> inliers = residuals(problem);
  const double expected = std::floor(kRows * (1.0 - ratio) + 0.5);
  // Copies are of random rows.
  EXPECT_NEAR(static_cast<double>(inliers.size()), expected, name == "copies" ? 0.1 * expected : 0.0);
  const double deviation = deviation_per_axis(inliers);
  if (problem_family(name).gaussian_noise) {
    EXPECT_NEAR(deviation, kSigma, 0.1 * kSigma);
    EXPECT_NEAR(share_within(inliers, 3.0), 0.971, 0.03);
  } else {
    // A Student t with three degrees of freedom has a deviation, but a sample's is far from it.
    EXPECT_GT(deviation, 0.6 * kSigma);
    EXPECT_LT(deviation, (name == "heavy_tails" ? 3.0 : 1.5) * kSigma);
    // Rounding of both clouds makes the mean square of `quantised` 5 / 3 of sigma^2, of which 0.85 are within.
    EXPECT_GT(share_within(inliers, 3.0), 0.78);
  }
}

TEST_P(Families, LetTheirOracleFindThePose) {
  const auto& [name, ratio] = GetParam();
  const Problem problem = problem_of(name, ratio);
  const RigidTransform found = oracle(problem);
  const double rmse = rmse_true_inliers(problem, found);
  EXPECT_LE(rmse, rmse_true_inliers(problem, problem.T_target_source));
  // Six parameters take little of the noise of hundreds of inliers.
  EXPECT_GT(rmse, 0.98 * std::sqrt(3.0) * deviation_per_axis(residuals(problem)));
  // About a rod's axis the turn is lost in noise.
  if (name != "linear") {
    EXPECT_LT(rotation_error_deg(found, problem.T_target_source), 0.5);
  }
}

TEST_P(Families, GiveTheSameBytesAgainAndOthersInTheNextTrial) {
  const auto& [name, ratio] = GetParam();
  const Problem once = problem_of(name, ratio);
  EXPECT_EQ(once.source, problem_of(name, ratio).source);
  EXPECT_EQ(once.target, problem_of(name, ratio).target);
  EXPECT_NE(once.target, problem_of(name, ratio, 1).target);
}

TEST_P(Families, HaveProblemsWithoutAPose) {
  const auto& [name, ratio] = GetParam();
  const Problem problem = problem_of(name, 1.0);
  EXPECT_EQ(problem.size(), kRows);
  EXPECT_TRUE(residuals(problem).empty());
}

TEST_P(Families, ComeInEveryNumberOfRowsAndOutliers) {
  const auto& [name, ratio] = GetParam();
  for (const std::size_t rows : {std::size_t{1}, std::size_t{3}, std::size_t{4}, std::size_t{11}}) {
    for (const double outliers : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      EXPECT_EQ(family_problem(name, {.correspondences = rows, .outlier_ratio = outliers}).size(), rows);
    }
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const ProblemFamily& family : problem_families()) all.emplace_back(family.name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(All, Families, testing::Combine(testing::ValuesIn(names()), testing::Values(0.5, 0.8)),
                         [](const auto& cell) {
                           return std::get<0>(cell.param) + (std::get<1>(cell.param) < 0.6 ? "_half" : "_most");
                         });

TEST(ProblemFamilies, BeginWithThePapers) {
  EXPECT_EQ(problem_families().front().name, "gaussian");
  const NoiseStudyOptions options{.correspondences = 100, .outlier_ratio = 0.7, .sigma = 2.0, .seed = 5, .trial = 6};
  EXPECT_EQ(family_problem("gaussian", options).target, noise_study_problem(options).target);
}

TEST(ProblemFamilies, HaveNamesOfTheirOwnAndASentence) {
  std::set<std::string_view> seen;
  for (const ProblemFamily& family : problem_families()) {
    EXPECT_TRUE(seen.insert(family.name).second);
    EXPECT_GT(family.sentence.size(), 20u);
    EXPECT_EQ(family.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string_view::npos);
    // But for the paper's, their data differ from the paper's.
    EXPECT_EQ(problem_of(family.name, 0.5).source == problem_of("gaussian", 0.5).source &&
                  problem_of(family.name, 0.5).target == problem_of("gaussian", 0.5).target,
              family.name == "gaussian");
  }
}

TEST(ProblemFamilies, RefuseWhatIsOutOfRange) {
  EXPECT_THAT([] { static_cast<void>(problem_family("magic")); },
              testing::ThrowsMessage<std::invalid_argument>(
                  testing::StartsWith("family 'magic': expected one of: gaussian, heavy_tails, ")));
  EXPECT_THROW(static_cast<void>(family_problem("", {})), std::invalid_argument);
  for (const ProblemFamily& family : problem_families()) {
    EXPECT_THROW(static_cast<void>(family_problem(family.name, {.correspondences = 0})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(family_problem(family.name, {.outlier_ratio = 1.5})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(family_problem(family.name, {.outlier_ratio = std::nan("")})),
                 std::invalid_argument);
    EXPECT_THROW(static_cast<void>(family_problem(family.name, {.sigma = -1.0})), std::invalid_argument);
    EXPECT_THROW(static_cast<void>(family_problem(family.name, {.scale = 0.0})), std::invalid_argument);
  }
}

// What each is named after.

TEST(ProblemFamilies, HeavyTailsReachFar) {
  const std::vector<Residual> inliers = residuals(problem_of("heavy_tails", 0.5));
  EXPECT_LT(share_within(inliers, 6.0), 1.0);
  EXPECT_GT(share_within(inliers, 1.0), 0.4);  // of a Gaussian 0.199
}

TEST(ProblemFamilies, RangeDependentNoiseGrowsWithTheDistance) {
  std::vector<Residual> near, far;
  for (const Residual& one : residuals(problem_of("range_dependent", 0.5))) {
    (one.source.norm() < 80.0 ? near : far).push_back(one);
  }
  EXPECT_GT(deviation_per_axis(far), 1.5 * deviation_per_axis(near));
}

TEST(ProblemFamilies, AnisotropicNoiseIsFiveTimesAsMuchAlongTheRay) {
  const Problem problem = problem_of("anisotropic", 0.5);
  double along = 0.0, across = 0.0;
  for (const Residual& one : residuals(problem)) {
    const Eigen::Vector3d ray = problem.T_target_source.linear() * one.source.normalized();
    const double part = one.error.dot(ray);
    along += part * part;
    across += 0.5 * (one.error.squaredNorm() - part * part);
  }
  EXPECT_NEAR(std::sqrt(along / across), 5.0, 0.5);
}

TEST(ProblemFamilies, QuantisedCoordinatesAreMultiples) {
  const Problem problem = problem_of("quantised", 0.5);
  for (const std::vector<double>& cloud : {problem.source, problem.target}) {
    for (const double x : cloud) ASSERT_EQ(x, std::round(x));  // of 2 sigma, 1 m
  }
}

TEST(ProblemFamilies, CopiesAreATenth) {
  const Problem problem = problem_of("copies", 0.5);
  std::set<std::vector<double>> distinct;
  for (std::size_t k = 0; k < kRows; ++k) {
    const Eigen::Vector3d source = row(problem.source, k), target = row(problem.target, k);
    distinct.insert({source[0], source[1], source[2], target[0], target[1], target[2]});
  }
  EXPECT_EQ(distinct.size(), kRows - kRows / 10);
}

TEST(ProblemFamilies, FarRowsAndRowsOfZerosAreATenthOfTheOutliers) {
  const auto count = [](const Problem& problem, const auto& holds) {
    std::size_t rows = 0;
    for (std::size_t k = 0; k < problem.size(); ++k) {
      if (!holds(row(problem.source, k).norm())) continue;
      EXPECT_EQ(problem.is_inlier[k], 0);
      ++rows;
    }
    return rows;
  };
  EXPECT_EQ(count(problem_of("far_rows", 0.5), [](double norm) { return norm > 1000.0; }), kRows / 20);
  EXPECT_EQ(count(problem_of("no_depth", 0.5), [](double norm) { return norm == 0.0; }), kRows / 20);
}

/// Share of the outliers for which `holds(source, target moved back)`.
template <typename Holds>
double share_of_outliers(const Problem& problem, const RigidTransform& motion, const Holds& holds) {
  double outliers = 0.0, count = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    if (problem.is_inlier[k] != 0) continue;
    ++outliers;
    count += holds(row(problem.source, k), Eigen::Vector3d(motion.inverse() * row(problem.target, k)));
  }
  return count / outliers;
}

TEST(ProblemFamilies, DecoysAreHalfAsManyAsInliers) {
  for (const char* const name : {"decoy", "symmetric"}) {
    const Problem problem = problem_of(name, 0.8);
    const auto agrees = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q) { return (p - q).norm() < 5 * kSigma; };
    EXPECT_NEAR(share_of_outliers(problem, problem.decoy_T_target_source, agrees), 0.125, 0.01) << name;
  }
}

TEST(ProblemFamilies, OutliersKeepTheirRange) {
  const Problem problem = problem_of("kept_range", 0.8);
  const auto keeps = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    return std::abs(p.norm() - q.norm()) < 5 * kSigma;
  };
  EXPECT_GT(share_of_outliers(problem, problem.decoy_T_target_source, keeps), 0.99);
  const Problem uniform = problem_of("gaussian", 0.8);
  EXPECT_LT(share_of_outliers(uniform, uniform.decoy_T_target_source, keeps), 0.2);
}

TEST(ProblemFamilies, ManyToManyIsMutualAndPermutedUsesTargetsOnce) {
  const auto most = [](const std::vector<double>& cloud) {
    std::map<std::vector<double>, int> times;
    int largest = 0;
    for (std::size_t k = 0; k < cloud.size(); k += 3) {
      largest = std::max(largest, ++times[{cloud[k], cloud[k + 1], cloud[k + 2]}]);
    }
    return largest;
  };
  const Problem many = problem_of("many_to_many", 0.8);
  EXPECT_EQ(most(many.source), 3);
  EXPECT_EQ(most(many.target), 3);
  EXPECT_EQ(most(problem_of("one_to_many", 0.8).source), 3);
  EXPECT_EQ(most(problem_of("permuted", 0.8).target), 1);
}

/// Mean squares of the sources' coordinates along their principal axes, ascending.
Eigen::Vector3d extents(const Problem& problem) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < problem.size(); ++k) mean += row(problem.source, k) / static_cast<double>(problem.size());
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const Eigen::Vector3d p = row(problem.source, k) - mean;
    squares += p * p.transpose() / static_cast<double>(problem.size());
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(squares).eigenvalues();
}

TEST(ProblemFamilies, ScenesHaveTheirShape) {
  const double cube = 100.0 * 100.0 / 3.0;
  EXPECT_GT(extents(problem_of("gaussian", 0.5))[0], 0.9 * cube);
  const Eigen::Vector3d planar = extents(problem_of("planar", 0.5));
  EXPECT_LT(planar[0], 0.01);
  EXPECT_GT(planar[1], 0.9 * cube);
  const Eigen::Vector3d linear = extents(problem_of("linear", 0.5));
  EXPECT_LT(linear[1], 0.01);
  EXPECT_GT(linear[2], 0.9 * cube);
  // A street is 200 m long, 25 m wide and 16.7 m high, and has no roof: two walls of 16.7 m, a ground of 25 m.
  const Eigen::Vector3d street = extents(problem_of("street", 0.5));
  EXPECT_GT(street[2], 0.9 * cube);
  EXPECT_LT(street[0], 60.0);
  EXPECT_LT(street[1], 200.0);
}

TEST(ProblemFamilies, AStreetHasNoRoof) {
  // Before its turn the ground is at one height only: of the points off both walls all lie in one plane.
  const Problem problem =
      hard_problem({.correspondences = 4000, .outlier_ratio = 0.0, .sigma = 0.0, .scene = Scene::street});
  const Problem corridor =
      hard_problem({.correspondences = 4000, .outlier_ratio = 0.0, .sigma = 0.0, .scene = Scene::corridor});
  const auto mean_height = [](const Problem& p) {
    // The scene's centre is the origin; a roof would balance the ground.
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < p.size(); ++k) mean += row(p.source, k) / static_cast<double>(p.size());
    return mean.norm();
  };
  // The ground has 25 of 25 + 2 * 16.7 parts and is 8.3 m below the centre. Sampling moves the length by about 1 m.
  EXPECT_NEAR(mean_height(problem), 8.33 * 25.0 / 58.3, 2.0);
  EXPECT_LT(mean_height(corridor), 3.0);
}

}  // namespace
}  // namespace consimd::synth
