#include <consimd/solvers/two_point_ransac.hpp>

#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <algorithm>
#include <ostream>
#include <tuple>

#include "problems.hpp"

namespace consimd {

void PrintTo(AngleTest test, std::ostream* out) {
  *out << (test == AngleTest::as_printed ? "as_printed" : "rotation_invariant");
}

namespace test {
namespace {

// 3 sigma of the problems here.
constexpr double kNoiseBound = 3.0;
constexpr double kLengthBound = 2.0 * kNoiseBound;

double angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// Bound minus left side of the angle test of m against the pair (i, j), in radians: above 0, m is consistent.
double angle_margin(const Problem& problem, const TwoPointOptions& options, std::uint32_t m, std::uint32_t i,
                    std::uint32_t j) {
  const Eigen::Vector3d x1 = source_point(problem, i) - source_point(problem, m);
  const Eigen::Vector3d x2 = source_point(problem, j) - source_point(problem, m);
  const Eigen::Vector3d y1 = target_point(problem, i) - target_point(problem, m);
  const Eigen::Vector3d y2 = target_point(problem, j) - target_point(problem, m);
  const double width = options.angle_bound;
  const double bound = std::asin(std::min(width / x1.norm(), 1.0)) + std::asin(std::min(width / x2.norm(), 1.0));
  if (options.angle_test == AngleTest::as_printed) {
    return m == i || m == j ? 1.0 : bound - (angle(x1, y1) + angle(x2, y2));
  }
  const bool uninformative = x1.norm() <= width || x2.norm() <= width;
  return uninformative ? 1.0 : bound - std::abs(angle(x1, x2) - angle(y1, y2));
}

/// Whether `members` are the candidates consistent with the pair; those on the border of a test may be either.
bool is_consensus_set_of(const Problem& problem, std::span<const std::uint32_t> candidates,
                         const TwoPointOptions& options, std::uint32_t i, std::uint32_t j,
                         std::span<const std::uint32_t> members) {
  constexpr double kAngleBorder = 1e-3;  // of the arc cosine in single precision, near angles of 0
  const double border = rounding(problem.correspondences());
  return std::ranges::all_of(candidates, [&](std::uint32_t m) {
    const double length_margin =
        kLengthBound - std::max(length_difference(problem, m, i), length_difference(problem, m, j));
    const double margin = angle_margin(problem, options, m, i, j);
    return std::ranges::binary_search(members, m) ? length_margin > -border && margin > -kAngleBorder
                                                  : length_margin < border || margin < kAngleBorder;
  });
}

/// 50 candidates, 30 of them inliers, among 80 correspondences, in an order of their own.
struct Candidates {
  Problem problem;
  std::vector<std::uint32_t> rows;
};

Candidates some_candidates(std::uint64_t seed, const RigidTransform& truth = RigidTransform::Identity()) {
  Candidates c{synth::noise_study_problem({.correspondences = 80, .outlier_ratio = 0.5, .seed = seed}), {}};
  c.problem = with_moved_target(c.problem, truth * c.problem.T_target_source.inverse());
  std::size_t inliers = 0;
  std::size_t outliers = 0;
  for (const std::uint32_t k : random_order(80, static_cast<std::uint32_t>(seed))) {
    if (c.problem.is_inlier[k] == 1 ? inliers++ < 30 : outliers++ < 20) c.rows.push_back(k);
  }
  return c;
}

class TwoPointRansac : public ::testing::TestWithParam<std::tuple<AngleTest, std::uint64_t>> {
 protected:
  static TwoPointOptions options(bool prune) {
    return {.consistency_bound = kLengthBound,
            .angle_bound = kNoiseBound,
            .angle_test = std::get<0>(GetParam()),
            .prune = prune,
            .seed = std::get<1>(GetParam())};
  }
};
INSTANTIATE_TEST_SUITE_P(TestsAndSeeds, TwoPointRansac,
                         ::testing::Combine(::testing::Values(AngleTest::rotation_invariant, AngleTest::as_printed),
                                            ::testing::Range(std::uint64_t{1}, std::uint64_t{5})));

TEST_P(TwoPointRansac, UnprunedIsTheConsensusSetOfAPair) {
  const auto [problem, candidates] = some_candidates(std::get<1>(GetParam()));
  TwoPointOptions two_point = options(false);
  two_point.angle_bound = 0.75;  // tight enough to tell apart what lengths alone let pass
  const ConsensusSet set = two_point_ransac(problem.correspondences(), candidates, two_point);
  EXPECT_EQ(set.score, set.members.size());
  EXPECT_TRUE(std::ranges::is_sorted(set.members, std::ranges::less_equal{}));
  for (const std::uint32_t k : set.members) EXPECT_TRUE(std::ranges::count(candidates, k) == 1) << k;
  bool found = false;
  for (std::size_t a = 0; a < candidates.size() && !found; ++a) {
    for (std::size_t b = 0; b < a && !found; ++b) {
      found = is_consensus_set_of(problem, candidates, two_point, candidates[a], candidates[b], set.members);
    }
  }
  EXPECT_TRUE(found);
}

TEST_P(TwoPointRansac, KeepsInliersOfCloudsThatAreHardlyRotated) {
  const auto [problem, candidates] = some_candidates(std::get<1>(GetParam()), motion(0.01, {1, 2, 3}, {40, 50, 60}));
  for (const bool prune : {false, true}) {
    const ConsensusSet set = two_point_ransac(problem.correspondences(), candidates, options(prune));
    const synth::InlierQuality quality = synth::inlier_quality(problem, set.members);
    EXPECT_GT(quality.precision, 0.85) << "prune " << prune;
    EXPECT_GT(quality.recall * static_cast<double>(true_inliers(problem).size()), 0.8 * 30.0) << "prune " << prune;
  }
}

TEST_P(TwoPointRansac, OnlyTheInvariantTestBearsRotation) {
  const auto [problem, candidates] = some_candidates(std::get<1>(GetParam()), motion(1.5, {1, 2, 3}, {40, 50, 60}));
  const ConsensusSet set = two_point_ransac(problem.correspondences(), candidates, options(true));
  const double kept =
      synth::inlier_quality(problem, set.members).recall * static_cast<double>(true_inliers(problem).size());
  if (std::get<0>(GetParam()) == AngleTest::rotation_invariant) {
    EXPECT_GT(kept, 0.8 * 30.0);
  } else {
    EXPECT_LT(kept, 0.5 * 30.0);
  }
}

class TwoPointStop : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(InlierShares, TwoPointStop, ::testing::Values(1.0, 0.7, 0.3));

TEST_P(TwoPointStop, FollowsTheClosedForm) {
  const Problem problem =
      synth::noise_study_problem({.correspondences = 500, .outlier_ratio = 1.0 - GetParam(), .sigma = 0.0});
  const Correspondences correspondences = problem.correspondences();
  const std::vector<std::uint32_t> candidates = all_rows(problem);
  std::uint64_t fewest = std::numeric_limits<std::uint64_t>::max();
  double needed = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ConsensusSet set = two_point_ransac(
        correspondences, candidates,
        {.consistency_bound = 0.01, .angle_bound = 0.01, .confidence = 0.99, .prune = false, .seed = seed});
    ASSERT_NEAR(static_cast<double>(set.score), 500.0 * GetParam(), 2.0);
    const double share = static_cast<double>(set.score) / 500.0;
    needed = share == 1.0 ? 1.0 : std::log(1.0 - 0.99) / std::log(1.0 - share * share);
    EXPECT_GE(static_cast<double>(set.iterations), needed) << "seed " << seed;
    EXPECT_LE(static_cast<double>(set.iterations), 2.0 * needed + 2.0) << "seed " << seed;
    fewest = std::min(fewest, set.iterations);
  }
  EXPECT_LE(static_cast<double>(fewest), std::ceil(needed) + 1.0);
}

TEST(TwoPointRansac, NeverExceedsMaxIterations) {
  const Problem problem = synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 1.0});
  const Correspondences correspondences = problem.correspondences();
  for (const std::uint32_t limit : {0u, 1u, 32u, 33u, 100u}) {
    const ConsensusSet set = two_point_ransac(
        correspondences, all_rows(problem), {.consistency_bound = 0.01, .angle_bound = 0.01, .max_iterations = limit});
    EXPECT_EQ(set.iterations, limit);
  }
}

TEST(TwoPointRansac, SmallInputs) {
  const Problem problem = synth::noise_study_problem({.correspondences = 10, .outlier_ratio = 0.0, .sigma = 0.0});
  const Correspondences correspondences = problem.correspondences();
  const TwoPointOptions options{.consistency_bound = 1.0, .angle_bound = 1.0};
  const std::vector<std::uint32_t> rows{7, 2};
  EXPECT_TRUE(two_point_ransac(correspondences, {}, options).members.empty());
  EXPECT_EQ(two_point_ransac(correspondences, std::span(rows).first(1), options).members,
            (std::vector<std::uint32_t>{7}));
  EXPECT_EQ(two_point_ransac(correspondences, rows, options).members, (std::vector<std::uint32_t>{2, 7}));
  const std::vector<std::uint32_t> beyond{1, 2, 10};
  EXPECT_THROW(static_cast<void>(two_point_ransac(correspondences, beyond, options)), std::out_of_range);
}

TEST(TwoPointRansac, RejectsBadOptions) {
  const Problem problem = synth::noise_study_problem({.correspondences = 10});
  const Correspondences correspondences = problem.correspondences();
  const auto run = [&](const TwoPointOptions& options) {
    return [&, options] { static_cast<void>(two_point_ransac(correspondences, all_rows(problem), options)); };
  };
  for (const double bound : kBadLengths) {
    expect_rejected(run({.consistency_bound = bound, .angle_bound = 1.0}), "consistency_bound", bound);
    expect_rejected(run({.consistency_bound = 1.0, .angle_bound = bound}), "angle_bound", bound);
  }
  for (const double confidence : kBadConfidences) {
    expect_rejected(run({.consistency_bound = 1.0, .angle_bound = 1.0, .confidence = confidence}), "confidence",
                    confidence);
  }
}

}  // namespace
}  // namespace test
}  // namespace consimd
