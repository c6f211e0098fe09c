// The pose belongs to the data, not to the order of rows, the unit or the frame they are given in.
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <ostream>

#include "problems.hpp"

namespace consimd::test {
namespace {

struct Cell {
  double outlier_ratio;
  double sigma;
};

void PrintTo(const Cell& cell, std::ostream* out) { *out << cell.outlier_ratio << " outliers, sigma " << cell.sigma; }

class TcfInvariance : public ::testing::TestWithParam<Cell> {
 protected:
  /// Both registrations of the same rows, up to the resolution of the refinement: a hundredth of the noise.
  void expect_same(const RigidTransform& a, const std::vector<std::uint32_t>& inliers_a, const RigidTransform& b,
                   const std::vector<std::uint32_t>& inliers_b) const {
    EXPECT_LT(synth::rotation_error_deg(a, b), 0.01 * sigma() / 2.0);  // half a degree moves the scene's rim by 1 m
    double furthest = 0.0;
    for (const std::uint32_t k : all_rows(problem_)) {
      furthest = std::max(furthest, ((a * source_point(problem_, k)) - (b * source_point(problem_, k))).norm());
    }
    EXPECT_LT(furthest, 0.02 * sigma());
    for (const std::uint32_t k : all_rows(problem_)) {
      if (std::abs(residual(problem_, a, k) - bound()) < furthest + 1e-3 * sigma()) continue;
      EXPECT_EQ(std::ranges::binary_search(inliers_a, k), std::ranges::binary_search(inliers_b, k)) << "row " << k;
    }
  }

  static Registration run(const Problem& problem, double noise_bound) {
    TcfOptions options;
    options.noise_bound = noise_bound;
    Registration result = register_tcf(problem.correspondences(), options);
    EXPECT_EQ(result.status, Status::success);
    return result;
  }

  [[nodiscard]] double sigma() const { return problem_.sigma; }
  [[nodiscard]] double bound() const { return synth::noise_study_bound(sigma()); }

  Problem problem_ = synth::noise_study_problem(
      {.correspondences = 1500, .outlier_ratio = GetParam().outlier_ratio, .sigma = GetParam().sigma, .seed = 11});
  Registration reference_ = run(problem_, bound());
};
INSTANTIATE_TEST_SUITE_P(Cells, TcfInvariance,
                         ::testing::Values(Cell{0.0, 1.0}, Cell{0.5, 2.0}, Cell{0.9, 0.1}, Cell{0.95, 1.0},
                                           Cell{0.98, 0.5}));

TEST_P(TcfInvariance, OrderOfRows) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const std::vector<std::uint32_t> order = random_order(problem_.size(), seed);
    const Registration shuffled = run(chosen_rows(problem_, order), bound());
    std::vector<std::uint32_t> inliers;
    for (const std::uint32_t k : shuffled.inliers) inliers.push_back(order[k]);
    std::ranges::sort(inliers);
    expect_same(reference_.T_target_source, reference_.inliers, shuffled.T_target_source, inliers);
  }
}

TEST_P(TcfInvariance, Unit) {
  for (const double factor : {1e-3, 1e3, 1024.0, 1e-20, 1e20}) {
    SCOPED_TRACE(::testing::Message() << factor << " units to the metre");
    Registration scaled = run(in_units(problem_, factor), bound() * factor);
    scaled.T_target_source.translation() /= factor;
    expect_same(reference_.T_target_source, reference_.inliers, scaled.T_target_source, scaled.inliers);
  }
}

TEST_P(TcfInvariance, MapCoordinates) {
  RigidTransform source_shift = RigidTransform::Identity();
  RigidTransform target_shift = RigidTransform::Identity();
  source_shift.translation() = Eigen::Vector3d(5e6, -5e6, 4e3);
  target_shift.translation() = Eigen::Vector3d(-5e6, 5e6, 5e6);
  Problem shifted = with_moved_target(problem_, target_shift);
  for (std::size_t k = 0; k < shifted.size(); ++k) {
    Eigen::Map<Eigen::Vector3d>(&shifted.source[3 * k]) = source_shift * source_point(problem_, k);
  }
  const Registration result = run(shifted, bound());
  const RigidTransform back = target_shift.inverse() * result.T_target_source * source_shift;
  expect_same(reference_.T_target_source, reference_.inliers, back, result.inliers);
}

TEST_P(TcfInvariance, RigidMotionOfTheTarget) {
  std::mt19937 random(5);
  for (int i = 0; i < 4; ++i) {
    const RigidTransform moved = random_motion(random);
    const Registration result = run(with_moved_target(problem_, moved), bound());
    expect_same(reference_.T_target_source, reference_.inliers, moved.inverse() * result.T_target_source,
                result.inliers);
  }
}

TEST_P(TcfInvariance, Seed) {
  for (const std::uint64_t seed : {2ULL, 3ULL, 0xFFFFFFFFFFFFFFFFULL}) {
    TcfOptions options;
    options.noise_bound = bound();
    options.seed = seed;
    const Registration result = register_tcf(problem_.correspondences(), options);
    expect_same(reference_.T_target_source, reference_.inliers, result.T_target_source, result.inliers);
  }
}

}  // namespace
}  // namespace consimd::test
