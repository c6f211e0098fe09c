// The stages of sc2_pcr and turboreg, each against plain loops over the same matrix.
#include <consimd/solvers/sc2_pcr.hpp>
#include <consimd/solvers/turboreg.hpp>
#include <consimd/synth/noise_study.hpp>

#include <Eigen/Eigenvalues>

#include <tuple>

#include "problems.hpp"

namespace consimd::test {
namespace {

bool bit(const ConsistencyMatrix& matrix, std::size_t i, std::size_t j) {
  return (matrix.row(i)[j / 64] >> (j % 64) & 1) != 0;
}

std::uint32_t common_neighbours(const ConsistencyMatrix& matrix, std::size_t i, std::size_t j) {
  std::uint32_t count = 0;
  for (std::size_t k = 0; k < matrix.size(); ++k) count += bit(matrix, i, k) && bit(matrix, j, k) ? 1U : 0U;
  return count;
}

Problem small_problem(std::uint64_t trial, double outlier_ratio = 0.6) {
  return synth::noise_study_problem({.correspondences = 150, .outlier_ratio = outlier_ratio, .trial = trial});
}

ConsistencyMatrix separated_matrix(const Correspondences& correspondences) {
  ConsistencyMatrix matrix;
  matrix.compute_separated(correspondences, 1.5, 5.0);
  return matrix;
}

TEST(Confidence, IsTheLeadingEigenvector) {
  for (std::uint64_t trial = 0; trial < 5; ++trial) {
    const Problem problem = small_problem(trial);
    ConsistencyMatrix matrix;
    matrix.compute(problem.correspondences(), 3.0);
    const auto size = static_cast<Eigen::Index>(matrix.size());
    Eigen::MatrixXd dense(size, size);
    for (Eigen::Index i = 0; i < size; ++i) {
      for (Eigen::Index j = 0; j < size; ++j) {
        dense(i, j) = bit(matrix, static_cast<std::size_t>(i), static_cast<std::size_t>(j)) ? 1.0 : 0.0;
      }
    }
    const Eigen::VectorXd leading = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense).eigenvectors().col(size - 1);
    const std::vector<float> confidence = compatibility_confidence(matrix, 200);
    ASSERT_EQ(confidence.size(), problem.size());
    for (Eigen::Index i = 0; i < size; ++i) {
      EXPECT_NEAR(static_cast<double>(confidence[static_cast<std::size_t>(i)]), std::abs(leading[i]), 1e-3);
    }
  }
  EXPECT_TRUE(compatibility_confidence(ConsistencyMatrix(), 10).empty());
}

TEST(Seeds, AreTheLocalMaximaThenTheOthers) {
  constexpr double kRadius = 35.0;
  const Problem problem = small_problem(1);
  const Correspondences correspondences = problem.correspondences();
  std::mt19937 random(3);
  std::vector<float> confidence(problem.size());
  for (float& c : confidence) c = static_cast<float>(random() % 40);  // with ties
  std::vector<std::tuple<bool, float, std::uint32_t>> expected;       // in ascending order of preference
  std::size_t maxima = 0;
  for (std::uint32_t i = 0; i < problem.size(); ++i) {
    bool exceeded = false;
    for (std::uint32_t j = 0; j < problem.size(); ++j) {
      if (confidence[j] > confidence[i] && (source_point(problem, i) - source_point(problem, j)).norm() < kRadius) {
        exceeded = true;
      }
    }
    expected.emplace_back(!exceeded, confidence[i], ~i);
    if (!exceeded) ++maxima;
  }
  std::ranges::sort(expected, std::ranges::greater{});
  EXPECT_GT(maxima, 5u);
  EXPECT_LT(maxima, 100u);
  for (const std::size_t count : {std::size_t{0}, maxima / 2, maxima, problem.size(), 2 * problem.size()}) {
    const std::vector<std::uint32_t> seeds = confidence_seeds(correspondences, confidence, kRadius, count);
    ASSERT_EQ(seeds.size(), std::min(count, problem.size()));
    for (std::size_t s = 0; s < seeds.size(); ++s) EXPECT_EQ(seeds[s], ~std::get<2>(expected[s])) << s;
  }
}

/// The other rows by falling merit; ties: the lower row. Merit 0: left out.
template <typename Merit>
std::vector<std::uint32_t> by_merit(std::vector<std::uint32_t> rows, std::size_t count, Merit merit) {
  std::ranges::stable_sort(rows, std::ranges::greater{}, merit);
  std::erase_if(rows, [&](std::uint32_t row) { return merit(row) == 0; });
  rows.resize(std::min(rows.size(), count));
  return rows;
}

TEST(SecondOrderPoses, AreOfTheSetsOfMostCommonNeighbours) {
  for (std::uint64_t trial = 0; trial < 5; ++trial) {
    const Problem problem = small_problem(trial);
    const Correspondences correspondences = problem.correspondences();
    const Sc2PcrOptions options{.noise_bound = 3.0, .first_set = 12, .second_set = 8};
    CompatibilityMatrices matrices;
    matrices.compute(correspondences, 3.0);
    const std::vector<std::uint32_t> seeds = all_rows(problem);
    const SeedPoses result = second_order_poses(correspondences, matrices, seeds, options);
    ASSERT_EQ(result.poses.size(), seeds.size());
    ASSERT_EQ(result.leading.size(), seeds.size());
    for (const std::uint32_t seed : seeds) {
      std::vector<std::uint32_t> others = seeds;
      std::erase_if(others, [&](std::uint32_t j) { return j == seed || !bit(matrices.loose, seed, j); });
      const std::vector<std::uint32_t> first =
          by_merit(others, 11, [&](std::uint32_t j) { return common_neighbours(matrices.tight, seed, j); });
      std::vector<std::uint32_t> ascending = first;
      std::ranges::sort(ascending);
      const std::vector<std::uint32_t> second = by_merit(ascending, 7, [&](std::uint32_t j) {
        return 1 + std::ranges::count_if(first, [&](std::uint32_t k) { return bit(matrices.loose, j, k); });
      });
      const IndexTriple& leading = result.leading[seed];
      EXPECT_EQ(leading.first, seed);
      if (second.size() < 2) {
        EXPECT_EQ(leading.second, seed);
        EXPECT_TRUE(std::isnan(result.poses[seed].rotation[0]));
        continue;
      }
      EXPECT_EQ(leading.second, second[0]);
      EXPECT_EQ(leading.third, second[1]);
    }
  }
}

TEST(SecondOrderPoses, OfInliersAreTheTruth) {
  const Problem problem =
      synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.5, .sigma = 0.0, .trial = 4});
  const Correspondences correspondences = problem.correspondences();
  CompatibilityMatrices matrices;
  matrices.compute(correspondences, 0.1);
  const std::vector<std::uint32_t> seeds = true_inliers(problem);
  const SeedPoses result = second_order_poses(correspondences, matrices, seeds, {.noise_bound = 0.1});
  for (const WorkingPose& pose : result.poses) {
    const RigidTransform T = to_caller_frame(from_working_pose(pose), correspondences);
    EXPECT_LT(displacement(problem, T, problem.T_target_source), 0.02);
  }
}

TEST(StrongestEdges, HaveMostCommonNeighbours) {
  for (std::uint64_t trial = 0; trial < 5; ++trial) {
    const ConsistencyMatrix matrix = separated_matrix(small_problem(trial).correspondences());
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> edges;  // weight, ~first, ~second
    for (std::uint32_t i = 0; i < matrix.size(); ++i) {
      for (std::uint32_t j = i + 1; j < matrix.size(); ++j) {
        const std::uint32_t weight = bit(matrix, i, j) ? common_neighbours(matrix, i, j) : 0;
        if (weight > 0) edges.emplace_back(weight, ~i, ~j);
      }
    }
    std::ranges::sort(edges, std::ranges::greater{});
    ASSERT_GT(edges.size(), 300u);
    for (const std::size_t count :
         {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{300}, edges.size() + 5}) {
      const std::vector<IndexPair> strongest = strongest_edges(matrix, count);
      ASSERT_EQ(strongest.size(), std::min(count, edges.size()));
      for (std::size_t e = 0; e < strongest.size(); ++e) {
        EXPECT_EQ(strongest[e].first, ~std::get<1>(edges[e]));
        EXPECT_EQ(strongest[e].second, ~std::get<2>(edges[e]));
      }
    }
  }
  EXPECT_TRUE(strongest_edges(ConsistencyMatrix(), 10).empty());
}

TEST(PivotCliques, AreTheHeaviestTrianglesBeyondThePivot) {
  const ConsistencyMatrix matrix = separated_matrix(small_problem(2).correspondences());
  const std::vector<IndexPair> pivots = strongest_edges(matrix, 200);
  for (const std::uint32_t per_pivot : {1U, 2U, 5U}) {
    std::vector<std::vector<IndexTriple>> of_place(per_pivot);
    for (const auto& [i, j] : pivots) {
      std::vector<std::tuple<std::uint32_t, std::uint32_t>> thirds;  // weight, ~k
      for (std::uint32_t k = j + 1; k < matrix.size(); ++k) {
        if (bit(matrix, i, k) && bit(matrix, j, k)) {
          thirds.emplace_back(common_neighbours(matrix, i, k) + common_neighbours(matrix, j, k), ~k);
        }
      }
      std::ranges::sort(thirds, std::ranges::greater{});
      for (std::size_t place = 0; place < std::min<std::size_t>(per_pivot, thirds.size()); ++place) {
        of_place[place].push_back({i, j, ~std::get<1>(thirds[place])});
      }
    }
    std::vector<IndexTriple> expected;
    for (const std::vector<IndexTriple>& cliques : of_place)
      expected.insert(expected.end(), cliques.begin(), cliques.end());
    const std::vector<IndexTriple> cliques = pivot_cliques(matrix, pivots, per_pivot);
    ASSERT_EQ(cliques.size(), expected.size());
    for (std::size_t c = 0; c < cliques.size(); ++c) {
      EXPECT_EQ(cliques[c].first, expected[c].first) << c;
      EXPECT_EQ(cliques[c].second, expected[c].second) << c;
      EXPECT_EQ(cliques[c].third, expected[c].third) << c;
    }
  }
  EXPECT_TRUE(pivot_cliques(matrix, {}, 2).empty());
}

}  // namespace
}  // namespace consimd::test
