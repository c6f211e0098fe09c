#include <consimd/kernels/rigid_moments.hpp>

#include <cstring>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

// NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): doubles alone, compared as bits on purpose
bool same_bits(const RigidMoments& a, const RigidMoments& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// NaN entries are equal whatever their sign and payload, on which processors differ.
RigidMoments with_plain_nans(RigidMoments moments) {
  auto* entries = &moments.weight;
  for (std::size_t k = 0; k < sizeof moments / sizeof *entries; ++k) {
    if (std::isnan(entries[k])) entries[k] = std::numeric_limits<double>::quiet_NaN();
  }
  return moments;
}

class Moments : public PerIsa {
 protected:
  static const detail::KernelTable& specification() { return detail::table_of(Isa::scalar); }

  void expect_equal(const RigidMoments& moments, const RigidMoments& expected) {
    ASSERT_TRUE(same_bits(with_plain_nans(moments), with_plain_nans(expected)));
  }
};
CONSIMD_FOR_EACH_ISA(Moments);

TEST_P(Moments, WeightedEqualTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float) {
    ExactArray<float> weights(cloud.padded(), std::nanf(""));
    for (std::size_t j = 0; j < cloud.size(); ++j) weights[j] = 0.5f + 0.5f * uniform(cloud.random());
    RigidMoments moments, expected;
    table().weighted_moments(cloud.view(), weights.data(), &moments);
    specification().weighted_moments(cloud.view(), weights.data(), &expected);
    expect_equal(moments, expected);
  });
}

TEST_P(Moments, OfASubsetEqualTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float) {
    ExactArray<std::uint64_t> bits(cloud.words());
    for (std::size_t j = 0; j < cloud.size(); ++j) bits[j / 64] |= std::uint64_t{cloud.random()() % 3 == 0} << (j % 64);
    RigidMoments moments, expected;
    table().subset_moments(cloud.view(), bits.data(), &moments);
    specification().subset_moments(cloud.view(), bits.data(), &expected);
    expect_equal(moments, expected);
  });
}

TEST_P(Moments, RobustEqualTheSpecification) {
  for_every_cloud([&](RawCloud& cloud, float bound) {
    const WorkingPose pose = any_pose(cloud.random());
    const float squared = bound * bound;
    for (const detail::RawWeight& weight :
         {detail::RawWeight{WeightFunction::truncated, 0.0f, squared, 0.0f, 0},
          detail::RawWeight{WeightFunction::cauchy, 4.0f / squared, squared, 0.0f, 0},
          detail::RawWeight{WeightFunction::student_uniform, 0.1f / squared, squared, 0.01f, 6},
          detail::RawWeight{WeightFunction::student_uniform, 9.0f / squared, squared, 0.5f, 1}}) {
      RigidMoments moments, expected;
      table().robust_moments(cloud.view(), pose, weight, &moments);
      specification().robust_moments(cloud.view(), pose, weight, &expected);
      expect_equal(moments, expected);
    }
  });
}

TEST_P(Moments, CrossSummationBlocks) {
  RawCloud cloud(2500, Kind::random, 5);
  ExactArray<float> weights(cloud.padded(), 1.0f);
  RigidMoments moments, expected;
  table().weighted_moments(cloud.view(), weights.data(), &moments);
  specification().weighted_moments(cloud.view(), weights.data(), &expected);
  expect_equal(moments, expected);
}

TEST_P(Moments, LeaveOutWhateverIsNotChosen) {
  RawCloud cloud(100, Kind::with_nan, 5);
  const auto view = cloud.view();
  ExactArray<std::uint64_t> finite(cloud.words());
  std::size_t count = 0;
  for (std::size_t j = 0; j < cloud.size(); ++j) {
    bool all = true;
    for (int axis = 0; axis < 3; ++axis)
      all = all && std::isfinite(view.source[axis][j]) && std::isfinite(view.target[axis][j]);
    finite[j / 64] |= std::uint64_t{all} << (j % 64);
    count += all ? 1 : 0;
  }
  RigidMoments moments;
  table().subset_moments(view, finite.data(), &moments);
  EXPECT_EQ(moments.weight, static_cast<double>(count));
  for (const double entry : moments.cross) EXPECT_TRUE(std::isfinite(entry));
}

TEST_P(Moments, MatchDoubleSums) {
  RawCloud cloud(3000, Kind::random, 9);
  const auto view = cloud.view();
  ExactArray<float> weights(cloud.padded(), std::nanf(""));
  RigidMoments expected{};
  for (std::size_t j = 0; j < cloud.size(); ++j) {
    weights[j] = 0.5f + 0.5f * uniform(cloud.random());
    const double w = double{weights[j]};
    expected.weight += w;
    for (std::size_t a = 0, s = 0; a < 3; ++a) {
      expected.source[a] += w * double{view.source[a][j]};
      expected.target[a] += w * double{view.target[a][j]};
      for (std::size_t b = 0; b < 3; ++b)
        expected.cross[3 * a + b] += w * double{view.target[a][j]} * double{view.source[b][j]};
      for (std::size_t b = a; b < 3; ++b)
        expected.source_scatter[s++] += w * double{view.source[a][j]} * double{view.source[b][j]};
    }
  }
  RigidMoments moments;
  table().weighted_moments(view, weights.data(), &moments);
  const auto* entry = &moments.weight;
  const auto* expected_entry = &expected.weight;
  for (std::size_t k = 0; k < sizeof moments / sizeof *entry; ++k) {
    EXPECT_NEAR(entry[k], expected_entry[k], 1e-6 * expected.weight) << "entry " << k;
  }
}

TEST(RobustMoments, FollowTheWeightFunctions) {
  // residuals 0, 1, 2 and 10 units under the identity; far correspondences at +-100 set the scale of the frame
  const std::array<double, 12> source{-100, 0, 0, 100, 0, 0, 0, 100, 0, 0, -100, 0};
  std::array<double, 12> target = source;
  const Correspondences even(PointSpan<double>::interleaved(source.data(), 4),
                             PointSpan<double>::interleaved(target.data(), 4));
  const WorkingPose identity{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {}};
  const auto residual_of = [&](double offset) {
    WorkingPose shifted = identity;
    shifted.translation[2] = static_cast<float>(offset * even.scale());
    return shifted;
  };
  RobustWeight weight{.scale = 2.0, .cutoff = 5.0, .odds = 0.25};
  for (const double offset : {0.0, 1.0, 2.0, 4.0, 6.0}) {
    const double x = offset * offset / 4.0;
    const bool inside = offset < weight.cutoff;
    weight.function = WeightFunction::truncated;
    EXPECT_NEAR(robust_moments(even, residual_of(offset), weight).weight, inside ? 4.0 : 0.0, 1e-5);
    weight.function = WeightFunction::cauchy;
    EXPECT_NEAR(robust_moments(even, residual_of(offset), weight).weight, inside ? 4.0 / (1.0 + x) : 0.0, 1e-5);
    weight.function = WeightFunction::student_uniform;
    for (const std::uint32_t exponent : {2U, 8U, 64U}) {
      weight.exponent = exponent;
      const double y = 1.0 + x / (2.0 * exponent);
      const double expected = inside ? 4.0 / (y * (1.0 + 0.25 * std::pow(y, exponent))) : 0.0;
      EXPECT_NEAR(robust_moments(even, residual_of(offset), weight).weight, expected, 1e-5);
      const double residual =
          robust_moments(even, residual_of(offset), weight).residual / (even.scale() * even.scale());
      EXPECT_NEAR(residual, expected * offset * offset, 1e-3);
    }
  }
  weight = {.function = WeightFunction::student_uniform, .scale = 1e-3, .cutoff = 1e3, .odds = 0.0};
  EXPECT_GT(robust_moments(even, residual_of(50.0), weight).weight, 0.0) << "no outliers, so no powers that overflow";
}

TEST(RobustMoments, CheckTheirParameters) {
  const std::array<double, 6> points{0, 0, 0, 1, 0, 0};
  const auto span = PointSpan<double>::interleaved(points.data(), 2);
  const Correspondences c(span, span);
  const WorkingPose identity{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {}};
  EXPECT_THROW((void)robust_moments(c, identity, {.scale = 0.0}), std::invalid_argument);
  EXPECT_THROW((void)robust_moments(c, identity, {.cutoff = -1.0}), std::invalid_argument);
  EXPECT_THROW((void)robust_moments(c, identity, {.odds = std::nan("")}), std::invalid_argument);
  EXPECT_THROW((void)robust_moments(c, identity, {.exponent = 3}), std::invalid_argument);
  EXPECT_THROW((void)subset_moments(c, {}), std::invalid_argument);
}

}  // namespace
}  // namespace consimd::test
