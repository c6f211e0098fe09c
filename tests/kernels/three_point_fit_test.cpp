#include <consimd/kernels/three_point_fit.hpp>

#include <cstring>

#include <consimd/poses/rigid_fit.hpp>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

class ThreePointFit : public PerIsa {};
CONSIMD_FOR_EACH_ISA(ThreePointFit);

std::vector<std::uint32_t> bits_with_plain_nans(const ExactArray<WorkingPose>& poses, std::size_t n) {
  std::vector<std::uint32_t> bits(12 * n);
  for (std::size_t h = 0; h < n; ++h) std::memcpy(bits.data() + 12 * h, poses[h].rotation, sizeof(WorkingPose));
  for (auto& entry : bits) {
    if ((entry & 0x7fffffff) > 0x7f800000) entry = 0x7fc00000;
  }
  return bits;
}

TEST_P(ThreePointFit, EqualsTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float) {
    std::vector<IndexTriple> triples(cloud.size() == 0 ? 0 : cloud.size() % 40);
    for (auto& triple : triples) triple = {cloud.any_index(), cloud.any_index(), cloud.any_index()};
    ExactArray<WorkingPose> poses(triples.size());
    ExactArray<WorkingPose> expected(triples.size());
    table().three_point_fits(cloud.view(), triples.data(), triples.size(), poses.data());
    detail::table_of(Isa::scalar).three_point_fits(cloud.view(), triples.data(), triples.size(), expected.data());
    ASSERT_EQ(bits_with_plain_nans(poses, triples.size()), bits_with_plain_nans(expected, triples.size()));
  });
}

struct Problem {
  Eigen::Matrix3Xd source, target;
  RigidTransform pose = RigidTransform::Identity();
  Correspondences correspondences;
  std::vector<IndexTriple> triples;
};

Problem noisy_problem(double noise) {
  constexpr Eigen::Index kSize = 300;
  std::mt19937 random(3);
  Problem problem;
  problem.pose.linear() = Eigen::Quaterniond(0.2, -0.7, 0.4, 0.5).normalized().toRotationMatrix();
  problem.pose.translation() = Eigen::Vector3d(5e6, -3.0, 12.0);
  problem.source = Eigen::Matrix3Xd::NullaryExpr(3, kSize, [&] { return 100.0 * double{uniform(random)}; });
  problem.target = problem.pose * problem.source;
  problem.target += Eigen::Matrix3Xd::NullaryExpr(3, kSize, [&] { return noise * double{uniform(random)}; });
  problem.correspondences = Correspondences(PointSpan<double>::interleaved(problem.source.data(), kSize),
                                            PointSpan<double>::interleaved(problem.target.data(), kSize));
  for (std::uint32_t h = 0; h < kSize / 3; ++h) problem.triples.push_back({3 * h, 3 * h + 1, 3 * h + 2});
  return problem;
}

/// Distances of the pose's images of the triple from their targets.
double rms(const Problem& problem, const RigidTransform& pose, const IndexTriple& triple) {
  double sum = 0.0;
  for (const Eigen::Index k : {triple.first, triple.second, triple.third}) {
    sum += (pose * problem.source.col(k) - problem.target.col(k)).squaredNorm();
  }
  return std::sqrt(sum / 3.0);
}

TEST_P(ThreePointFit, RecoversExactPoses) {
  set_active_isa(GetParam());
  const Problem problem = noisy_problem(0.0);
  std::vector<WorkingPose> poses(problem.triples.size());
  three_point_fits(problem.correspondences, problem.triples, poses);
  for (const WorkingPose& pose : poses) {
    const RigidTransform T = to_caller_frame(from_working_pose(pose), problem.correspondences);
    EXPECT_LT((T.linear() - problem.pose.linear()).norm(), 3e-5);
    EXPECT_LT((T * problem.source.col(0) - problem.target.col(0)).norm(), 5e-3);
  }
}

TEST_P(ThreePointFit, IsTheLeastSquaresFitAndNeverAReflection) {
  set_active_isa(GetParam());
  const Problem problem = noisy_problem(60.0);
  std::vector<WorkingPose> poses(problem.triples.size());
  three_point_fits(problem.correspondences, problem.triples, poses);
  for (std::size_t h = 0; h < poses.size(); ++h) {
    const IndexTriple& triple = problem.triples[h];
    const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> rotation(poses[h].rotation);
    EXPECT_NEAR(rotation.determinant(), 1.0f, 1e-5f);
    EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3f::Identity()).norm(), 1e-5f);

    Eigen::Matrix3d p, q;
    p << problem.source.col(triple.first), problem.source.col(triple.second), problem.source.col(triple.third);
    q << problem.target.col(triple.first), problem.target.col(triple.second), problem.target.col(triple.third);
    const RigidTransform best(Eigen::umeyama(p, q, false));
    const RigidTransform fit = to_caller_frame(from_working_pose(poses[h]), problem.correspondences);
    EXPECT_NEAR(rms(problem, fit, triple), rms(problem, best, triple), 1e-3);
  }
}

TEST_P(ThreePointFit, DegenerateTriplesHaveNoPose) {
  set_active_isa(GetParam());
  // 0 1 2 a triangle in both clouds; 3 on the line 0-1 in the source alone; 4 equal to 0; 5 on the line 0-1 in the
  // target alone
  const std::array<double, 18> source{0, 0, 0, 1, 0, 0, 0, 1, 0, 0.5, 0, 0, 0, 0, 0, 0, 0, 1};
  const std::array<double, 18> target{0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0.5, 0};
  const Correspondences c(PointSpan<double>::interleaved(source.data(), 6),
                          PointSpan<double>::interleaved(target.data(), 6));
  const std::vector<IndexTriple> triples{{0, 1, 2}, {0, 1, 3}, {0, 4, 1}, {0, 1, 5}, {2, 2, 2}, {0, 1, 1}};
  std::vector<WorkingPose> poses(triples.size());
  three_point_fits(c, triples, poses);
  for (std::size_t h = 0; h < poses.size(); ++h) {
    for (const float entry : poses[h].rotation) EXPECT_EQ(std::isnan(entry), h != 0) << h;
    for (const float entry : poses[h].translation) EXPECT_EQ(std::isnan(entry), h != 0) << h;
  }
}

TEST(ThreePointFitArguments, AreChecked) {
  const Problem problem = noisy_problem(0.0);
  std::vector<WorkingPose> poses(1);
  std::vector<IndexTriple> triples{{0, 1, 300}};
  EXPECT_THROW(three_point_fits(problem.correspondences, triples, poses), std::out_of_range);
  EXPECT_THROW(three_point_fits(problem.correspondences, triples, {}), std::invalid_argument);
}

}  // namespace
}  // namespace consimd::test
