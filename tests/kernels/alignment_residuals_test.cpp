#include <consimd/kernels/alignment_residuals.hpp>

#include <bit>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

float squared_residual(const detail::RawView& v, const WorkingPose& pose, std::size_t j) {
  float squared = 0.0f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float* r = pose.rotation + 3 * axis;
    const float moved =
        ((r[0] * v.source[0][j] + r[1] * v.source[1][j]) + r[2] * v.source[2][j]) + pose.translation[axis];
    const float difference = moved - v.target[axis][j];
    squared = axis == 0 ? difference * difference : squared + difference * difference;
  }
  return squared;
}

class AlignmentResiduals : public PerIsa {
 protected:
  static std::vector<WorkingPose> poses_for(RawCloud& cloud) {
    std::vector<WorkingPose> poses(cloud.size() % 6);
    for (auto& pose : poses) pose = any_pose(cloud.random());
    if (poses.size() == 5) poses[3].rotation[4] = std::numeric_limits<float>::quiet_NaN();
    return poses;
  }
};
CONSIMD_FOR_EACH_ISA(AlignmentResiduals);

TEST_P(AlignmentResiduals, EqualTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float bound) {
    const auto poses = poses_for(cloud);
    expect_consensus(
        cloud, poses.size(),
        [&](std::size_t h, std::size_t j) { return squared_residual(cloud.view(), poses[h], j) < bound * bound; },
        [&](std::uint32_t* counts) {
          table().alignment_counts(cloud.view(), poses.data(), poses.size(), bound, counts);
        },
        [&](std::uint64_t* bits, std::uint32_t* counts) {
          table().alignment_bits(cloud.view(), poses.data(), poses.size(), bound, bits, counts);
        });
  });
}

TEST_P(AlignmentResiduals, ScoresEqualTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float bound) {
    const auto poses = poses_for(cloud);
    ExactArray<PoseSupport> support(poses.size());
    table().alignment_scores(cloud.view(), poses.data(), poses.size(), bound, support.data());
    for (std::size_t h = 0; h < poses.size(); ++h) {
      std::array<float, 16> sums{};
      std::uint32_t count = 0;
      for (std::size_t j = 0; j < cloud.size(); ++j) {
        const float r = squared_residual(cloud.view(), poses[h], j);
        if (!(r < bound * bound)) continue;
        sums[j % 16] += r;
        ++count;
      }
      for (std::size_t half = 8; half > 0; half /= 2) {
        for (std::size_t l = 0; l < half; ++l) sums[l] += sums[l + half];
      }
      ASSERT_EQ(support[h].count, count);
      const float score = static_cast<float>(count) - sums[0] / (bound * bound);
      ASSERT_EQ(std::bit_cast<std::uint32_t>(support[h].score), std::bit_cast<std::uint32_t>(score));
    }
  });
}

TEST_P(AlignmentResiduals, ValuesEqualTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float) {
    for (const WorkingPose& pose : poses_for(cloud)) {
      const detail::RawView& view = cloud.view();
      ExactArray<float> squared(view.padded);
      table().alignment_residuals(view, pose, squared.data());
      for (std::size_t j = 0; j < view.size; ++j) {
        const float expected = squared_residual(view, pose, j);
        if (std::isnan(expected)) {
          ASSERT_TRUE(std::isnan(squared[j]));
        } else {
          ASSERT_EQ(std::bit_cast<std::uint32_t>(squared[j]), std::bit_cast<std::uint32_t>(expected));
        }
      }
      for (std::size_t j = view.size; j < view.padded; ++j) ASSERT_TRUE(std::isnan(squared[j]));
    }
  });
}

TEST(AlignmentResidualsArguments, AreChecked) {
  const std::array<double, 9> points{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const auto span = PointSpan<double>::interleaved(points.data(), 3);
  const Correspondences c(span, span);
  const std::vector<WorkingPose> poses{{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {}}};
  std::vector<std::uint32_t> counts(1);
  std::vector<std::uint64_t> bits(1);
  std::vector<PoseSupport> support(1);
  alignment_bits(c, poses, 0.1, bits, counts);
  alignment_scores(c, poses, 0.1, support);
  EXPECT_EQ(counts[0], 3u);
  EXPECT_EQ(bits[0], 7u);
  EXPECT_EQ(support[0].count, 3u);
  EXPECT_EQ(support[0].score, 3.0f);
  std::vector<float> squared(c.view().words() * kBlock);
  alignment_residuals(c, poses[0], squared);
  EXPECT_EQ(squared[2], 0.0f);
  EXPECT_THROW(alignment_residuals(c, poses[0], std::span(squared).first(3)), std::invalid_argument);
  EXPECT_THROW(alignment_counts(c, poses, std::nan(""), counts), std::invalid_argument);
  EXPECT_THROW(alignment_counts(c, poses, 0.1, {}), std::invalid_argument);
  EXPECT_THROW(alignment_scores(c, poses, 0.1, {}), std::invalid_argument);
  EXPECT_THROW(alignment_bits(c, poses, 0.1, {}, counts), std::invalid_argument);
}

}  // namespace
}  // namespace consimd::test
