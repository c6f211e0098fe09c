// How many seeds the search with care draws.
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <cmath>
#include <cstdint>

#include "problems.hpp"
#include "search/consensus_search.hpp"

namespace consimd::test {
namespace {

constexpr std::size_t kRows = 2000;

struct Drawn {
  bool exhaustive;
  std::uint32_t seeds;
  std::uint32_t support;  // of the best pose
};

Drawn drawn_with_care(synth::OutlierModel outliers, double confidence) {
  const Problem problem = synth::hard_problem(
      {.correspondences = kRows, .outlier_ratio = 1.0, .outliers = outliers, .clusters = 3, .cluster_sigma = 6.0});
  const Correspondences correspondences = problem.correspondences();
  detail::ConsensusSearch search(
      correspondences,
      {.noise_bound = synth::noise_study_bound(problem.sigma), .confidence = confidence, .settles = false});
  search.run(false);
  search.run(true);
  return {search.exhaustive(), search.sets().drawn(), search.best().support.count};
}

double missed(const Drawn& drawn) {
  return std::pow(1.0 - 0.8 * drawn.support / static_cast<double>(kRows), drawn.seeds);
}

TEST(SearchWithCare, IsNotNeededWhereFewPairsAgree) {
  const Drawn drawn = drawn_with_care(synth::OutlierModel::uniform, 0.99);
  EXPECT_LT(drawn.support, 20U);
  EXPECT_TRUE(drawn.exhaustive);
  EXPECT_LT(drawn.seeds, kRows);
}

TEST(SearchWithCare, EndsWhenASupporterOfAnyRivalHasBeenDrawn) {
  const Drawn drawn = drawn_with_care(synth::OutlierModel::clustered, 0.99);
  EXPECT_GT(drawn.support, 20U);
  EXPECT_LT(drawn.seeds, kRows / 2);
  EXPECT_LT(missed(drawn), 0.00102);  // four fifths of the support are rounded down
}

TEST(SearchWithCare, DrawsMoreForMoreConfidence) {
  const Drawn drawn = drawn_with_care(synth::OutlierModel::clustered, 1.0 - 1e-6);
  EXPECT_LT(missed(drawn), 1.02e-6);
  EXPECT_GT(drawn.seeds, drawn_with_care(synth::OutlierModel::clustered, 0.99).seeds);
}

}  // namespace
}  // namespace consimd::test
