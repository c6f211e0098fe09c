// The kernels of the iterative closest points: every instruction set against the specification, bit for bit, and the
// specification against textbook forms in double precision.
#include <consimd/kernels/pair_equations.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <array>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "raw_points.hpp"

namespace consimd::test {
namespace {

constexpr PairMetric kMetrics[] = {PairMetric::point, PairMetric::plane, PairMetric::gicp};
constexpr std::size_t kWords = PairBlock::kSize / 64;

class PairKernels : public PerIsa {
 protected:
  const detail::CloudKernels& kernels() const { return table().clouds; }
  static const detail::CloudKernels& specification() { return detail::table_of(Isa::scalar).clouds; }
};
CONSIMD_FOR_EACH_ISA(PairKernels);

/// The cloud's points and normals as moving ones with some nearest points; behind them what must not be read.
std::unique_ptr<PairBlock> block_of(const detail::RawPoints& points, RawCloud& cloud, float bound) {
  auto block = std::make_unique<PairBlock>();
  std::memset(static_cast<void*>(block.get()), 0xff, sizeof(PairBlock));  // NaN, and rows beyond any cloud
  for (std::size_t i = 0; i < points.size; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      block->from[c][i] = points.points[c][i];
      block->points[c][i] = points.points[c][i];
      block->normals[c][i] = points.normals[c][i];
      block->looked[c][i] = points.points[c][i] + 0.5f * bound * uniform(cloud.random());
    }
    block->trust[i] = bound * uniform(cloud.random());
    // Itself, any other or none.
    const auto choice = cloud.random()() % 4;
    block->rows[i] = static_cast<std::uint32_t>(choice == 0 ? points.size : i);
    if (choice == 1) block->rows[i] = cloud.any_index();
  }
  return block;
}

PairProblem problem_of(PairMetric metric, float bound, std::mt19937& random) {
  const WorkingPose pose = any_pose(random);
  PairProblem problem{metric, {}, {}, 2.0f * bound, 0.25f * bound};
  for (std::size_t k = 0; k < 9; ++k) problem.rotation[k] = pose.rotation[k];
  for (float& c : problem.centre) c = bound * uniform(random);
  return problem;
}

std::vector<std::uint32_t> bits_of(const PairEquations& equations) {
  std::vector<std::uint32_t> bits = test::bits_of(equations.normal, 21);
  for (const std::uint32_t word : test::bits_of(equations.score, 6)) bits.push_back(word);
  const float sums[] = {equations.weight, equations.spread, equations.squared_score, equations.slope,
                        equations.squared_length};
  for (const std::uint32_t word : test::bits_of(sums, 5)) bits.push_back(word);
  bits.push_back(equations.pairs);
  return bits;
}

TEST_P(PairKernels, MotionsEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float bound) {
    const WorkingPose pose = any_pose(cloud.random());
    WorkingMotion motion{};
    for (std::size_t k = 0; k < 9; ++k) {
      motion.linear[k] = pose.rotation[k];
      motion.linear_rest[k] = 0x1p-26f * uniform(cloud.random());
    }
    for (std::size_t k = 0; k < 3; ++k) {
      motion.shift[k] = pose.translation[k];
      motion.shift_rest[k] = 0x1p-26f * uniform(cloud.random());
    }
    const auto block = block_of(points, cloud, bound), expected = std::make_unique<PairBlock>(*block);
    std::array<std::uint64_t, kWords> stale, expected_stale;
    stale.fill(~std::uint64_t{0});
    expected_stale.fill(~std::uint64_t{0});
    kernels().move_pairs(*block, points.size, motion, stale.data());
    specification().move_pairs(*expected, points.size, motion, expected_stale.data());
    ASSERT_EQ(stale, expected_stale);
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(test::bits_of(block->points[c], points.size), test::bits_of(expected->points[c], points.size));
    }
  });
}

TEST_P(PairKernels, ResidualsEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float bound) {
    const auto block = block_of(points, cloud, bound);
    for (const PairMetric metric : kMetrics) {
      const PairProblem problem = problem_of(metric, bound, cloud.random());
      ExactArray<float> squared(points.size), expected(points.size);
      kernels().pair_residuals(points, *block, points.size, problem, squared.data());
      specification().pair_residuals(points, *block, points.size, problem, expected.data());
      ASSERT_EQ(test::bits_of(squared.data(), points.size), test::bits_of(expected.data(), points.size));
    }
  });
}

TEST_P(PairKernels, EquationsEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float bound) {
    const auto block = block_of(points, cloud, bound);
    for (const PairMetric metric : kMetrics) {
      const PairProblem problem = problem_of(metric, bound, cloud.random());
      PairEquations equations, expected;
      kernels().pair_equations(points, *block, points.size, problem, equations);
      specification().pair_equations(points, *block, points.size, problem, expected);
      ASSERT_EQ(bits_of(equations), bits_of(expected)) << static_cast<int>(metric);
    }
  });
}

/// A cloud with unit normals, and a block of points near its own.
struct Scene {
  explicit Scene(std::size_t size) {
    std::mt19937 random(3);
    std::vector<float> points(3 * size);
    for (float& x : points) x = uniform(random);
    cloud = Cloud(PointSpan<float>::interleaved(points.data(), size));
    std::array<std::vector<float>, 3> normals;
    for (std::size_t i = 0; i < size; ++i) {
      const Eigen::Vector3f normal = direction(random), own = direction(random);
      for (std::size_t c = 0; c < 3; ++c) {
        normals[c].push_back(normal[static_cast<Eigen::Index>(c)]);
        block.normals[c][i] = own[static_cast<Eigen::Index>(c)];
        block.points[c][i] = cloud.view().points(c)[i] + 0.1f * uniform(random);
      }
      block.rows[i] = static_cast<std::uint32_t>(i);
    }
    cloud.set_normals({normals[0].data(), normals[1].data(), normals[2].data()});
  }

  static Eigen::Vector3f direction(std::mt19937& random) {
    return Eigen::Vector3f(uniform(random), uniform(random), uniform(random)).normalized();
  }

  Cloud cloud;
  PairBlock block{};
};

Eigen::Vector3d entry(const float points[3][PairBlock::kSize], std::size_t i) {
  return Eigen::Vector3f(points[0][i], points[1][i], points[2][i]).cast<double>();
}

TEST(PairEquations, AreTheTextbooks) {
  constexpr std::size_t kSize = 300;
  const Scene scene(kSize);
  const CloudView view = scene.cloud.view();
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.6, 0.0, 0.8)).toRotationMatrix();
  for (const PairMetric metric : kMetrics) {
    PairProblem problem{metric, {}, {0.1f, -0.2f, 0.05f}, 0.12f, 0.03f};
    for (Eigen::Index k = 0; k < 9; ++k) problem.rotation[k] = static_cast<float>(rotation(k / 3, k % 3));
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> score = Eigen::Matrix<double, 6, 1>::Zero();
    double weight = 0.0, spread = 0.0, squared_score = 0.0, slope = 0.0, squared_length = 0.0;
    std::uint32_t pairs = 0;
    std::vector<float> squared(kSize);
    pair_residuals(view, scene.block, kSize, problem, squared);
    for (std::size_t i = 0; i < kSize; ++i) {
      const Eigen::Vector3d x = entry(scene.block.points, i);
      const Eigen::Vector3d q(static_cast<double>(view.points(0)[i]), static_cast<double>(view.points(1)[i]),
                              static_cast<double>(view.points(2)[i]));
      const Eigen::Vector3d e = x - q;
      if (e.norm() > 0.12) {
        EXPECT_TRUE(std::isnan(squared[i]));
        continue;
      }
      const Eigen::Vector3d n(static_cast<double>(view.normals(0)[i]), static_cast<double>(view.normals(1)[i]),
                              static_cast<double>(view.normals(2)[i]));
      const Eigen::Vector3d m = rotation * entry(scene.block.normals, i);
      Eigen::Matrix3d metric_matrix = Eigen::Matrix3d::Identity();
      if (metric == PairMetric::plane) metric_matrix = n * n.transpose();
      if (metric == PairMetric::gicp) {
        const auto covariance = [](const Eigen::Vector3d& along) {
          return Eigen::Matrix3d(Eigen::Matrix3d::Identity() - (1.0 - 1e-3) * (along * along.transpose()));
        };
        metric_matrix = 2e-3 * (covariance(n) + covariance(m)).inverse();
      }
      const double r2 = e.dot(metric_matrix * e);
      EXPECT_NEAR(static_cast<double>(squared[i]), r2, 1e-5 * e.squaredNorm());
      const double w = 1.0 / (1.0 + r2 / (2.3849 * 2.3849 * 0.03 * 0.03));
      const Eigen::Vector3d a = x - Eigen::Vector3d(0.1, -0.2, 0.05);
      Eigen::Matrix<double, 3, 6> jacobian;
      jacobian << 0.0, a[2], -a[1], 1.0, 0.0, 0.0, -a[2], 0.0, a[0], 0.0, 1.0, 0.0, a[1], -a[0], 0.0, 0.0, 0.0, 1.0;
      normal += w * jacobian.transpose() * metric_matrix * jacobian;
      score += w * jacobian.transpose() * metric_matrix * e;
      weight += w;
      spread += w * a.squaredNorm();
      squared_score += w * w * r2;
      slope += w * (2.0 * w - 1.0);
      squared_length += metric == PairMetric::plane ? r2 : e.squaredNorm();
      ++pairs;
    }
    const PairEquations equations = pair_equations(view, scene.block, kSize, problem);
    EXPECT_EQ(equations.pairs, pairs);
    EXPECT_GT(pairs, 100u);
    EXPECT_LT(pairs, kSize);
    const double rounding = 1e-5 * weight;
    for (int r = 0, k = 0; r < 6; ++r) {
      for (int c = 0; c <= r; ++c, ++k) {
        EXPECT_NEAR(static_cast<double>(equations.normal[k]), normal(r, c), rounding) << r << " " << c;
      }
      EXPECT_NEAR(static_cast<double>(equations.score[r]), score[r], 0.1 * rounding) << r;
    }
    EXPECT_NEAR(static_cast<double>(equations.weight), weight, rounding);
    EXPECT_NEAR(static_cast<double>(equations.spread), spread, rounding);
    EXPECT_NEAR(static_cast<double>(equations.squared_score), squared_score, 0.1 * rounding);
    EXPECT_NEAR(static_cast<double>(equations.slope), slope, rounding);
    EXPECT_NEAR(static_cast<double>(equations.squared_length), squared_length, 0.1 * rounding);
  }
}

TEST(PairEquations, OfPointsWithoutNormalAreLeftOut) {
  Scene scene(20);
  std::array<std::vector<float>, 3> normals;
  for (auto& axis : normals) axis.assign(20, std::numeric_limits<float>::quiet_NaN());
  scene.cloud.set_normals({normals[0].data(), normals[1].data(), normals[2].data()});
  for (const PairMetric metric : kMetrics) {
    const PairProblem problem{metric, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {}, 1.0f, 0.1f};
    const PairEquations equations = pair_equations(scene.cloud.view(), scene.block, 20, problem);
    EXPECT_EQ(equations.pairs, metric == PairMetric::point ? 20u : 0u);
    EXPECT_EQ(equations.weight > 0.0f, metric == PairMetric::point);
  }
}

TEST(PairEquations, MoveFinerThanSinglePrecision) {
  // 0.5 and a quarter of its rounding, and back.
  PairBlock block{};
  block.from[0][0] = -0.5f;
  WorkingMotion motion{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.5f, 0, 0}, {}, {0x1p-27f, 0, 0}};
  std::array<std::uint64_t, kWords> stale;
  move_pairs(block, 1, motion, stale);
  EXPECT_EQ(block.points[0][0], 0x1p-27f);
  EXPECT_EQ(stale[0], 1u);  // no trust
  block.trust[0] = 0x1p-20f;
  move_pairs(block, 1, motion, stale);
  EXPECT_EQ(stale[0], 0u);
  block.looked[1][0] = std::numeric_limits<float>::quiet_NaN();
  move_pairs(block, 1, motion, stale);
  EXPECT_EQ(stale[0], 1u);
}

TEST(PairEquations, NameWhatIsWrong) {
  Scene scene(20);
  const CloudView view = scene.cloud.view();
  PairProblem problem{PairMetric::plane, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {}, 1.0f, 0.1f};
  std::array<std::uint64_t, kWords> stale;
  std::vector<float> squared(20);
  EXPECT_THROW(move_pairs(scene.block, 513, WorkingMotion{}, stale), std::invalid_argument);
  EXPECT_THROW((void)pair_equations(view, scene.block, 513, problem), std::invalid_argument);
  EXPECT_THROW(pair_residuals(view, scene.block, 19, problem, squared), std::invalid_argument);
  const std::array<float, 3> point{};
  const Cloud bare(PointSpan<float>::interleaved(point.data(), 1));
  EXPECT_THROW((void)pair_equations(bare.view(), scene.block, 0, problem), std::invalid_argument);
  scene.block.rows[7] = 20;  // none
  EXPECT_EQ(pair_equations(view, scene.block, 20, problem).pairs, 19u);
  scene.block.rows[7] = 21;
  try {
    (void)pair_equations(view, scene.block, 20, problem);
    ADD_FAILURE() << "row 21 of 20 taken";
  } catch (const std::out_of_range& error) {
    EXPECT_NE(std::string(error.what()).find("row 21 of 20"), std::string::npos) << error.what();
  }
  scene.block.rows[7] = 7;
  for (const float scale : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()}) {
    problem.scale = scale;
    EXPECT_THROW((void)pair_equations(view, scene.block, 20, problem), std::invalid_argument);
  }
}

}  // namespace
}  // namespace consimd::test
