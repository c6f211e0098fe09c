// The kernels on clouds: every instruction set against the specification, bit for bit, and the
// specification against textbook forms.
#include <consimd/kernels/neighbourhoods.hpp>
#include <consimd/kernels/pair_features.hpp>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "raw_points.hpp"

namespace consimd::test {
namespace {

class CloudKernels : public PerIsa {
 protected:
  const detail::CloudKernels& kernels() const { return table().clouds; }
  static const detail::CloudKernels& specification() { return detail::table_of(Isa::scalar).clouds; }
};
CONSIMD_FOR_EACH_ISA(CloudKernels);

std::vector<std::uint32_t> any_indices(RawCloud& cloud) {
  std::vector<std::uint32_t> indices(cloud.size() == 0 ? 0 : cloud.random()() % (cloud.size() + 1));
  for (auto& index : indices) index = cloud.any_index();
  return indices;
}

TEST_P(CloudKernels, NeighboursEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float bound) {
    const auto size = static_cast<std::uint32_t>(cloud.size());
    const std::uint32_t middle = size == 0 ? 0 : cloud.any_index();
    const std::vector<PointRun> runs{{0, middle}, {middle, middle}, {middle, size}, {size / 3, size / 2}};
    const float query[3] = {size == 0 ? 0.0f : points.points[0][middle], 0.125f * bound, 0.0f};
    ExactArray<std::uint32_t> indices(2 * size + 16), expected_indices(2 * size + 16);
    ExactArray<float> squared(2 * size + 16), expected_squared(2 * size + 16);
    const std::size_t count = kernels().neighbours_within(points, query, runs.data(), runs.size(), 2.0f * bound,
                                                          indices.data(), squared.data());
    const std::size_t expected = specification().neighbours_within(
        points, query, runs.data(), runs.size(), 2.0f * bound, expected_indices.data(), expected_squared.data());
    ASSERT_EQ(count, expected);
    ASSERT_TRUE(std::equal(indices.data(), indices.data() + count, expected_indices.data()));
    ASSERT_EQ(bits_of(squared.data(), count), bits_of(expected_squared.data(), count));
  });
}

/// The nearest points by sorting all.
std::vector<std::pair<float, std::uint32_t>> sorted_by_distance(const detail::RawPoints& points, const float query[3],
                                                                const std::vector<PointRun>& runs, float radius) {
  std::vector<std::pair<float, std::uint32_t>> all;
  for (const PointRun& run : runs) {
    for (std::uint32_t i = run.first; i < run.last; ++i) {
      const float x = points.points[0][i] - query[0], y = points.points[1][i] - query[1],
                  z = points.points[2][i] - query[2];
      const float squared = x * x + y * y + z * z;
      if (squared <= radius * radius) all.emplace_back(squared, i);
    }
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST_P(CloudKernels, NearestEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float bound) {
    const auto size = static_cast<std::uint32_t>(cloud.size());
    const std::uint32_t middle = size == 0 ? 0 : cloud.any_index();
    std::vector<PointRun> runs{{middle, size}, {middle, middle}, {0, middle}};  // not in order
    const std::size_t most = 1 + cloud.random()() % 33;
    float query[3] = {size == 0 ? 0.0f : points.points[0][middle], 0.125f * bound, 0.0f};
    for (const float radius : {2.0f * bound, 8.0f * bound}) {
      ExactArray<std::uint32_t> indices(most), expected(most);
      ExactArray<float> squared(most), expected_squared(most);
      const auto run = [&](const detail::CloudKernels& set, ExactArray<std::uint32_t>& rows, ExactArray<float>& d) {
        return set.nearest_within(points, query, runs.data(), runs.size(), radius, most, rows.data(), d.data());
      };
      const std::size_t count = run(kernels(), indices, squared);
      ASSERT_EQ(count, run(specification(), expected, expected_squared));
      ASSERT_EQ(indices.values(), expected.values());
      ASSERT_EQ(bits_of(squared.data(), most), bits_of(expected_squared.data(), most));

      const auto all = sorted_by_distance(points, query, runs, radius);
      ASSERT_EQ(count, std::min(most, all.size()));
      for (std::size_t rank = 0; rank < count; ++rank) {
        ASSERT_EQ(indices[rank], all[rank].second) << rank << " of " << most << ", size " << size;
        ASSERT_EQ(squared[rank], all[rank].first);
      }
    }
    query[1] = std::numeric_limits<float>::quiet_NaN();
    std::uint32_t index = 7;
    float distance = 7.0f;
    ASSERT_EQ(kernels().nearest_within(points, query, runs.data(), runs.size(), bound, 1, &index, &distance), 0u);
    ASSERT_EQ(index, 7u);
  });
}

TEST_P(CloudKernels, ScattersEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float bound) {
    const std::vector<std::uint32_t> indices = any_indices(cloud);
    if (indices.empty()) return;
    const float centre[3] = {0.0f, bound, points.points[2][indices[0]]};
    float scatter[6];
    float expected[6];
    kernels().neighbourhood_scatter(points, centre, indices.data(), indices.size(), bound, scatter);
    specification().neighbourhood_scatter(points, centre, indices.data(), indices.size(), bound, expected);
    ASSERT_EQ(bits_of(scatter, 6), bits_of(expected, 6));
  });
}

TEST_P(CloudKernels, AxesEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float) {
    const std::size_t n = cloud.size();
    const std::size_t room = (n + 15) / 16 * 16;
    std::vector<ExactArray<float>> entries, axes, expected;
    for (int k = 0; k < 6; ++k) {
      entries.emplace_back(room);
      axes.emplace_back(room);
      expected.emplace_back(room);
      const float* from = k < 3 ? points.points[k] : points.normals[k - 3];
      std::copy_n(from, n, entries.back().data());
    }
    const float* const in[6] = {entries[0].data(), entries[1].data(), entries[2].data(),
                                entries[3].data(), entries[4].data(), entries[5].data()};
    const auto run = [&](const detail::CloudKernels& set, std::vector<ExactArray<float>>& out) {
      float* const smallest[3] = {out[0].data(), out[1].data(), out[2].data()};
      float* const values[3] = {out[3].data(), out[4].data(), out[5].data()};
      set.principal_axes(in, n, smallest, values);
    };
    run(kernels(), axes);
    run(specification(), expected);
    for (std::size_t k = 0; k < 6; ++k) ASSERT_EQ(bits_of(axes[k].data(), n), bits_of(expected[k].data(), n));
  });
}

TEST_P(CloudKernels, PairFeaturesEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float) {
    if (cloud.size() == 0) return;
    const std::vector<std::uint32_t> indices = any_indices(cloud);
    const std::uint32_t point = cloud.any_index();
    ExactArray<std::uint32_t> counts(kPairFeatureBins, 7), expected(kPairFeatureBins, 8);
    kernels().pair_feature_counts(points, point, indices.data(), indices.size(), counts.data());
    specification().pair_feature_counts(points, point, indices.data(), indices.size(), expected.data());
    ASSERT_EQ(counts.values(), expected.values());
  });
}

TEST_P(CloudKernels, HistogramSumsEqualTheSpecification) {
  for_every_point_cloud([&](const detail::RawPoints& points, RawCloud& cloud, float) {
    const std::size_t table_rows = cloud.size() / 48;
    std::vector<std::uint32_t> rows(table_rows == 0 ? 0 : cloud.size() % 29);
    for (auto& row : rows) row = cloud.any_index() % static_cast<std::uint32_t>(table_rows);
    ExactArray<float> histograms(48 * table_rows), squared(rows.size()), sum(48, 7.0f), expected(48, 8.0f);
    std::copy_n(points.points[0], 48 * table_rows, histograms.data());
    for (std::size_t j = 0; j < rows.size(); ++j) squared[j] = std::fabs(points.points[1][j]);
    kernels().weighted_histogram_sum(histograms.data(), rows.data(), squared.data(), rows.size(), sum.data());
    specification().weighted_histogram_sum(histograms.data(), rows.data(), squared.data(), rows.size(),
                                           expected.data());
    ASSERT_EQ(bits_of(sum.data(), 48), bits_of(expected.data(), 48));
  });
}

TEST_P(CloudKernels, AxesAreEigenvectors) {
  set_active_isa(GetParam());
  std::mt19937 random(9);
  ScatterBatch scatter{};
  PrincipalAxes axes{};
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Eigen::Matrix3f> matrices;
    for (std::size_t i = 0; i < ScatterBatch::kSize; ++i) {
      Eigen::Matrix3f m = Eigen::Matrix3f::NullaryExpr([&] { return uniform(random); });
      if (trial % 3 == 1) m.row(2) *= 1e-3f;
      if (trial % 3 == 2) m.row(1) = 1e-4f * m.row(1);
      m = (m.transpose() * m).eval();
      if (i == 0) m = Eigen::Matrix3f::Identity();
      if (i == 1) m.setZero();
      matrices.push_back(m);
      const float entries[6] = {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
      for (int k = 0; k < 6; ++k) scatter.entries[k][i] = entries[k];
    }
    principal_axes(scatter, ScatterBatch::kSize, axes);
    for (std::size_t i = 0; i < ScatterBatch::kSize; ++i) {
      const Eigen::Matrix3d m = matrices[i].cast<double>();
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> expected(m);
      const Eigen::Vector3d axis(axes.smallest_axes[0][i], axes.smallest_axes[1][i], axes.smallest_axes[2][i]);
      const double tolerance = 4e-6 * expected.eigenvalues()[2];
      EXPECT_NEAR(axis.norm(), 1.0, 2e-6);
      EXPECT_LE((m * axis - expected.eigenvalues()[0] * axis).norm(), tolerance);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(double{axes.values[k][i]}, expected.eigenvalues()[k], tolerance);
    }
  }
}

/// The three features as the paper writes them, in double; nothing where there is no frame.
std::optional<Eigen::Vector3d> textbook_features(const Eigen::Vector3d& p1, const Eigen::Vector3d& n1,
                                                 const Eigen::Vector3d& p2, const Eigen::Vector3d& n2) {
  Eigen::Vector3d d = p2 - p1;
  Eigen::Vector3d source = n1, target = n2;
  if (std::abs(n1.dot(d)) < std::abs(n2.dot(d))) {
    d = -d;
    std::swap(source, target);
  }
  const Eigen::Vector3d v = d.cross(source);
  if (d.norm() == 0.0 || v.norm() == 0.0) return std::nullopt;
  const Eigen::Vector3d w = source.cross(v.normalized());
  return Eigen::Vector3d(std::atan2(w.dot(target), source.dot(target)) / std::numbers::pi, v.normalized().dot(target),
                         source.dot(d.normalized()));
}

TEST(PairFeatures, AreThePapersAwayFromTheBordersOfBins) {
  std::mt19937 random(11);
  constexpr std::uint32_t kSize = 3000;
  Eigen::Matrix3Xf points = Eigen::Matrix3Xf::NullaryExpr(3, kSize, [&] { return uniform(random); });
  Eigen::Matrix3Xf normals = Eigen::Matrix3Xf::NullaryExpr(3, kSize, [&] { return uniform(random); });
  normals.colwise().normalize();
  Cloud cloud(PointSpan<float>::interleaved(points.data(), kSize));
  const Eigen::MatrixX3f columns = normals.transpose();
  cloud.set_normals({columns.data(), columns.data() + kSize, columns.data() + 2 * kSize});
  std::uint32_t compared = 0;
  for (std::uint32_t j = 1; j < kSize; ++j) {
    const auto features = textbook_features(points.col(0).cast<double>(), normals.col(0).cast<double>(),
                                            points.col(j).cast<double>(), normals.col(j).cast<double>());
    ASSERT_TRUE(features);
    const Eigen::Array3d places = 11.0 * (*features + Eigen::Vector3d::Ones()).array() / 2.0;
    if (((places - places.round()).abs() < 1e-3).any()) continue;
    std::array<std::uint32_t, kPairFeatureBins> counts{}, expected{};
    for (std::size_t f = 0; f < 3; ++f) ++expected[11 * f + static_cast<std::size_t>(places[static_cast<int>(f)])];
    pair_feature_counts(cloud, 0, std::span(&j, 1), counts);
    ASSERT_EQ(counts, expected) << features->transpose();
    ++compared;
  }
  EXPECT_GT(compared, kSize * 9 / 10);
}

TEST(PairFeatures, OfAPairWithoutAFrameAreNotCounted) {
  // a pair of no length, one along both normals, one without a normal, and a proper one
  const std::array<float, 15> points{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 0, 1, 0, 0};
  Cloud cloud(PointSpan<float>::interleaved(points.data(), 5));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::array<float, 5> x{0, 0, 0, nan, 0}, y{0, 0, 0, nan, 0}, z{1, 1, 1, nan, 1};
  const std::vector<std::uint32_t> indices{0, 1, 2, 3, 4};
  std::array<std::uint32_t, kPairFeatureBins> counts{};
  EXPECT_THROW(pair_feature_counts(cloud, 0, indices, counts), std::invalid_argument);
  cloud.set_normals({x.data(), y.data(), z.data()});
  pair_feature_counts(cloud, 0, indices, counts);
  EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0u), 3u);
  for (const std::size_t f : {0u, 1u, 2u}) EXPECT_EQ(counts[11 * f + 5], 1u);
  const std::uint32_t beyond = 5;
  EXPECT_THROW(pair_feature_counts(cloud, 0, std::span(&beyond, 1), counts), std::out_of_range);
}

TEST(Nearest, NameWhatIsWrong) {
  const std::array<float, 6> points{0, 0, 0, 1, 0, 0};
  const Cloud cloud(PointSpan<float>::interleaved(points.data(), 2));
  const std::array<float, 3> query{0.0f, 0.0f, 0.0f};
  std::array<std::uint32_t, 2> rows{};
  std::array<float, 2> squared{};
  const std::array<PointRun, 1> all{{{0, 2}}}, beyond{{{0, 3}}};
  EXPECT_EQ(nearest_within(cloud, query, all, 0.6, rows, squared), 2u);
  EXPECT_EQ(rows[0], 0u);  // both are as near
  EXPECT_THROW(nearest_within(cloud, query, beyond, 0.6, rows, squared), std::out_of_range);
  EXPECT_THROW(nearest_within(cloud, query, all, -1.0, rows, squared), std::invalid_argument);
  EXPECT_THROW(nearest_within(cloud, query, all, 1.0, {}, {}), std::invalid_argument);
  EXPECT_THROW(nearest_within(cloud, query, all, 1.0, rows, std::span(squared).first(1)), std::invalid_argument);
}

}  // namespace
}  // namespace consimd::test
