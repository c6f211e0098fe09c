#include <consimd/solvers/pcr99.hpp>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

TEST(Pcr99Ranking, CostsAreThoseOfPlainLoops) {
  const Problem problem = synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.8});
  const Pcr99Options options{.noise_bound = 3.0};
  const std::vector<float> costs = ranking_costs(problem.correspondences(), options);
  ASSERT_EQ(costs.size(), 300u);
  double inliers = 0.0;
  double outliers = 0.0;
  for (std::size_t i = 0; i < 300; ++i) {
    double cost = 0.0;
    for (std::size_t j = 0; j < 300; ++j) {
      if (i == j) continue;
      const double a = (source_point(problem, i) - source_point(problem, j)).norm();
      const double b = (target_point(problem, i) - target_point(problem, j)).norm();
      cost += std::min({std::max(std::tanh(std::abs(std::log(b / a))) / std::tanh(0.1), std::abs(b - a) / 3.0), 1.0});
    }
    EXPECT_NEAR(static_cast<double>(costs[i]), cost, 1e-3 * cost);
    (problem.is_inlier[i] != 0 ? inliers : outliers) += cost / (problem.is_inlier[i] != 0 ? 60.0 : 240.0);
  }
  EXPECT_LT(inliers, outliers - 20.0);
}

TEST(Pcr99Triples, AreThoseOfPlainLoopsInOrder) {
  for (const std::size_t size : {0U, 2U, 3U, 4U, 9U, 70U, 150U}) {
    const Problem problem =
        synth::noise_study_problem({.correspondences = std::max<std::size_t>(size, 1), .outlier_ratio = 0.7});
    std::vector<std::uint32_t> rows = all_rows(problem);
    rows.resize(size);
    const Correspondences correspondences = problem.correspondences().subset(rows);
    ConsistencyMatrix matrix;
    matrix.compute_ratio(correspondences, 30.0, std::tanh(0.3));
    const auto good = [&](std::size_t i, std::size_t j) { return (matrix.row(i)[j / 64] >> (j % 64) & 1) != 0; };
    std::vector<std::tuple<std::size_t, std::size_t, std::size_t>> expected;  // sum, i, j
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = i + 1; j < size; ++j) {
        for (std::size_t k = j + 1; k < size; ++k) {
          if (good(i, j) && good(i, k) && good(j, k)) expected.emplace_back(i + j + k, i, j);
        }
      }
    }
    std::ranges::sort(expected);
    RankedTriples order(matrix);
    std::vector<std::tuple<std::size_t, std::size_t, std::size_t>> found;
    std::vector<IndexTriple> batch;
    do {
      order.next(7, std::numeric_limits<std::uint64_t>::max(), batch);
      EXPECT_LE(batch.size(), 7u);
      for (const IndexTriple& t : batch) found.emplace_back(t.first + t.second + t.third, t.first, t.second);
    } while (!batch.empty());
    EXPECT_EQ(found, expected) << size;
    EXPECT_TRUE(order.done());
    EXPECT_EQ(order.looked_at(), size < 3 ? 0 : size * (size - 1) * (size - 2) / 6);
    if (size == 150) {
      EXPECT_GT(expected.size(), 1000u);
      RankedTriples limited(matrix);
      limited.next(1'000'000, 5000, batch);
      EXPECT_FALSE(limited.done());
      EXPECT_LT(limited.looked_at(), 5100u);
    }
  }
}

TEST(Pcr99Triples, BestConnectedAreThoseOfPlainLoops) {
  const Correspondences correspondences =
      synth::noise_study_problem({.correspondences = 150, .outlier_ratio = 0.7}).correspondences();
  ConsistencyMatrix matrix;
  matrix.compute_ratio(correspondences, 30.0, std::tanh(0.3));
  RankedTriples order(matrix);
  std::vector<IndexTriple> all;
  order.next(700, std::numeric_limits<std::uint64_t>::max(), all);
  ASSERT_EQ(all.size(), 700u);
  const auto good = [&](std::size_t i, std::size_t j) { return (matrix.row(i)[j / 64] >> (j % 64) & 1) != 0; };
  using Ranked = std::pair<int, std::size_t>;  // missing neighbours, position: the least are the best
  std::vector<Ranked> ranked;
  for (std::size_t t = 0; t < all.size(); ++t) {
    int common = 0;
    for (std::size_t i = 0; i < 150; ++i)
      common += good(i, all[t].first) && good(i, all[t].second) && good(i, all[t].third);
    ranked.emplace_back(-common, t);
  }
  std::ranges::sort(ranked);
  for (const std::size_t count : {1U, 30U, 699U, 700U, 800U}) {
    std::vector<Ranked> expected(ranked.begin(),
                                 ranked.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(count, 700)));
    std::ranges::sort(expected, {}, &Ranked::second);
    std::vector<IndexTriple> kept = all;
    keep_best_connected(matrix, count, kept);
    ASSERT_EQ(kept.size(), expected.size());
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const IndexTriple& triple = all[expected[k].second];
      EXPECT_EQ(std::tie(kept[k].first, kept[k].second, kept[k].third),
                std::tie(triple.first, triple.second, triple.third))
          << count << " " << k;
    }
  }
}

// Thirty inliers of three thousand, with noise for which pairs agree by chance: all triples in order are too many.
TEST(Pcr99, ScreeningFindsThePoseAmongManyTriples) {
  const Problem problem =
      synth::noise_study_problem({.correspondences = 3000, .outlier_ratio = 0.99, .sigma = 5.0, .trial = 2});
  Pcr99Options options{.noise_bound = 15.0};
  const Registration screened = register_pcr99(problem.correspondences(), options);
  expect_sound(screened, problem, 15.0);
  EXPECT_EQ(screened.status, Status::success);
  options.max_screened = 1;
  EXPECT_FALSE(register_pcr99(problem.correspondences(), options).has_pose());
}

TEST(Pcr99, MaySearchTheBestRankedRowsAlone) {
  const Problem problem = synth::noise_study_problem({.correspondences = 2000, .outlier_ratio = 0.9});
  Pcr99Options options{.noise_bound = 3.0};
  options.matrix_budget_bytes = ConsistencyMatrix::memory_bytes(300);
  const Registration result = register_pcr99(problem.correspondences(), options);
  expect_sound(result, problem, 3.0);
  EXPECT_EQ(result.status, Status::success);
  ASSERT_EQ(result.stages.size(), 4u);
  EXPECT_EQ(result.stages[1].name, "pairs");
  EXPECT_EQ(result.stages[1].input, 2000u);
  EXPECT_GE(result.stages[1].output, 300u);
  EXPECT_LT(result.stages[1].output, 400u);
}

TEST(Pcr99, PublishedTestOfRatiosFindsThePose) {
  const Problem problem = synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.9});
  const Pcr99Options options{.noise_bound = 3.0, .length_tolerance = kInfinity, .ranking_tolerance = kInfinity};
  const Registration result = register_pcr99(problem.correspondences(), options);
  EXPECT_EQ(result.status, Status::success);
  EXPECT_LT(synth::rmse_true_inliers(problem, result.T_target_source), 3.0);
}

TEST(Pcr99, BadOptionsAreRejected) {
  const Correspondences some = synth::noise_study_problem({.correspondences = 50}).correspondences();
  const auto expect_bad = [&](const std::string& name, double value, const std::function<void(Pcr99Options&)>& change) {
    for (const bool estimate_scale : {false, true}) {
      Pcr99Options options{.noise_bound = 1.0, .estimate_scale = estimate_scale};
      change(options);
      expect_rejected([&] { static_cast<void>(register_pcr99(some, options)); }, name, value);
    }
  };
  for (const double length : kBadLengths) {
    expect_bad("noise_bound", length, [&](Pcr99Options& o) { o.noise_bound = length; });
    expect_bad("inlier_tolerance", length, [&](Pcr99Options& o) { o.inlier_tolerance = length; });
  }
  for (const double tolerance : {0.0, -1.0, kNan}) {
    expect_bad("length_tolerance", tolerance, [&](Pcr99Options& o) { o.length_tolerance = tolerance; });
    expect_bad("ranking_tolerance", tolerance, [&](Pcr99Options& o) { o.ranking_tolerance = tolerance; });
    expect_bad("ratio_tolerance", tolerance, [&](Pcr99Options& o) { o.ratio_tolerance = tolerance; });
  }
  expect_bad("ratio_tolerance", 1.5, [](Pcr99Options& o) { o.ratio_tolerance = 1.5; });
  expect_bad("batch", 0.0, [](Pcr99Options& o) { o.batch = 0; });
  expect_bad("max_hypotheses", 0.0, [](Pcr99Options& o) { o.max_hypotheses = 0; });
  expect_bad("max_screened", 0.0, [](Pcr99Options& o) { o.max_screened = 0; });
  expect_bad("max_triples", 0.0, [](Pcr99Options& o) { o.max_triples = 0; });
  expect_bad("matrix_budget_bytes", 100.0, [](Pcr99Options& o) { o.matrix_budget_bytes = 100; });
}

}  // namespace
}  // namespace consimd::test
