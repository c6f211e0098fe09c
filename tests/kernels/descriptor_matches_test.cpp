// Best matches of descriptors: every instruction set against sorting all, and against the reference.
#include <consimd/kernels/descriptor_matches.hpp>

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

class DescriptorMatches : public PerIsa {};
CONSIMD_FOR_EACH_ISA(DescriptorMatches);

std::vector<float> random_descriptors(std::mt19937& random, std::size_t size, std::size_t length, bool tied) {
  std::vector<float> values(size * length);
  for (float& value : values) value = tied ? static_cast<float>(random() % 3) : uniform(random);
  return values;
}

std::vector<std::uint32_t> listed(const BestMatches& matches) {
  std::vector<std::uint32_t> list;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    for (std::size_t rank = 0; rank < matches.k(); ++rank) {
      list.push_back(matches.index(i, rank));
      list.push_back(static_cast<std::uint32_t>(matches.squared_distance(i, rank)));
    }
  }
  return list;
}

/// The k nearest of `targets` by sorting all.
std::vector<std::uint32_t> nearest(const std::vector<std::vector<std::int32_t>>& queries,
                                   const std::vector<std::vector<std::int32_t>>& targets, std::size_t k) {
  std::vector<std::uint32_t> list;
  for (const auto& query : queries) {
    std::vector<std::pair<std::int32_t, std::uint32_t>> all;
    for (std::uint32_t j = 0; j < targets.size(); ++j) {
      std::int32_t sum = 0;
      for (std::size_t c = 0; c < query.size(); ++c) sum += (query[c] - targets[j][c]) * (query[c] - targets[j][c]);
      all.emplace_back(sum, j);
    }
    std::sort(all.begin(), all.end());
    all.resize(std::max(all.size(), k), {std::numeric_limits<std::int32_t>::max(), BestMatches::kNone});
    for (std::size_t rank = 0; rank < k; ++rank) {
      list.push_back(all[rank].second);
      list.push_back(static_cast<std::uint32_t>(all[rank].first));
    }
  }
  return list;
}

std::vector<std::vector<std::int32_t>> in_units(const std::vector<float>& values, std::size_t length, double unit) {
  std::vector<std::vector<std::int32_t>> rows(values.size() / length);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t c = 0; c < length; ++c) {
      rows[i].push_back(static_cast<std::int32_t>(std::nearbyint(static_cast<double>(values[i * length + c]) / unit)));
    }
  }
  return rows;
}

TEST_P(DescriptorMatches, MatchesAreTheNearest) {
  set_active_isa(GetParam());
  std::mt19937 random(5);
  for (const std::size_t length : {1u, 2u, 3u, 4u, 7u, 8u, 9u, 10u, 33u, 256u}) {
    for (std::size_t size = 0; size < 70; size = size < 34 ? size + 1 : size + 7) {
      for (const bool tied : {false, true}) {
        const std::size_t others = random() % 50;
        const std::size_t k = 1 + random() % 8;
        const std::vector<float> a = random_descriptors(random, size, length, tied);
        const std::vector<float> b = random_descriptors(random, others, length, tied);
        const FixedPointForm form(a, b, length);
        const FixedPointDescriptors queries(a, form), targets(b, form);
        BestMatches of_queries(queries, k), of_targets(targets, k);
        best_matches(queries, targets, of_queries, of_targets, 1, 2);
        best_matches(queries, targets, of_queries, of_targets, 0, 2);
        const auto whole_a = in_units(a, length, form.unit()), whole_b = in_units(b, length, form.unit());
        ASSERT_EQ(listed(of_queries), nearest(whole_a, whole_b, k)) << length << " " << size << " " << others;
        ASSERT_EQ(listed(of_targets), nearest(whole_b, whole_a, k)) << length << " " << size << " " << others;

        BestMatches merged(targets, k), of_parts(queries, k);
        for (std::size_t part = 0; part < 3; ++part) {
          BestMatches of_part(targets, k);
          best_matches(queries, targets, of_parts, of_part, part, 3);
          merged.merge(of_part);
        }
        ASSERT_EQ(listed(merged), listed(of_targets));
        ASSERT_EQ(listed(of_parts), listed(of_queries));
      }
    }
  }
}

TEST_P(DescriptorMatches, MatchesOfManyThatLieInClustersAreThoseOfTheReference) {
  std::mt19937 random(6);
  for (const std::size_t length : {8u, 33u}) {
    for (const float width : {0.0f, 0.01f, 0.3f}) {
      // A quarter of them are copies.
      const auto clustered = [&](std::size_t size) {
        const std::vector<float> centres = random_descriptors(random, 9, length, false);
        std::vector<float> values = random_descriptors(random, size, length, false);
        for (std::size_t i = 0; i < values.size(); ++i) {
          values[i] = centres[i / length % 9 * length + i % length] + (i / length % 4 == 0 ? 0.0f : width * values[i]);
        }
        return values;
      };
      const std::vector<float> a = clustered(1003), b = clustered(1290);
      const FixedPointForm form(a, b, length);
      const FixedPointDescriptors queries(a, form), targets(b, form);
      const auto matches = [&](Isa isa, std::size_t parts) {
        set_active_isa(isa);
        BestMatches of_queries(queries, 3), of_targets(targets, 3);
        for (std::size_t part = 0; part < parts; ++part) {
          best_matches(queries, targets, of_queries, of_targets, part, parts);
        }
        return std::pair(listed(of_queries), listed(of_targets));
      };
      const auto expected = matches(Isa::scalar, 1);
      EXPECT_EQ(matches(GetParam(), 1), expected) << length << " " << width;
      EXPECT_EQ(matches(GetParam(), 4), expected) << length << " " << width;
    }
  }
}

TEST_P(DescriptorMatches, DistancesReachTheirLimitWithoutOverflow) {
  set_active_isa(GetParam());
  std::vector<float> values(2 * 33, 0.0f);
  values[0] = 100.0f;
  values[33] = -100.0f;
  const FixedPointForm form(values, {}, 33);
  const FixedPointDescriptors descriptors(values, form);
  BestMatches a(descriptors, 2), b(descriptors, 2);
  best_matches(descriptors, descriptors, a, b);
  EXPECT_EQ(a.index(0, 0), 0u);
  EXPECT_EQ(a.squared_distance(0, 0), 0);
  EXPECT_EQ(a.index(0, 1), 1u);
  EXPECT_NEAR(std::sqrt(a.squared_distance(0, 1)) * form.unit(), 200.0, 0.02);
}

TEST_P(DescriptorMatches, BoxesReachTheirLimitWithoutOverflow) {
  set_active_isa(GetParam());
  // Opposite ends of the sphere of the largest norm, in all components that boxes know, in more than one tile.
  std::vector<float> a, b;
  for (std::size_t i = 0; i < 40; ++i) {
    for (std::size_t c = 0; c < 4; ++c) {
      a.push_back(i % 2 == 0 ? 50.0f : -50.0f);
      b.push_back(i % 2 == 0 ? -50.0f : 50.0f);
    }
  }
  const FixedPointForm form(a, b, 4);
  const FixedPointDescriptors queries(a, form), targets(b, form);
  BestMatches of_queries(queries, 2), of_targets(targets, 2);
  best_matches(queries, targets, of_queries, of_targets);
  EXPECT_EQ(listed(of_queries), nearest(in_units(a, 4, form.unit()), in_units(b, 4, form.unit()), 2));
  EXPECT_EQ(listed(of_targets), nearest(in_units(b, 4, form.unit()), in_units(a, 4, form.unit()), 2));
}

TEST(FixedPointDescriptors, NameWhatIsWrong) {
  std::vector<float> values(66, 1.0f);
  const auto error_of = [&](auto&& make) {
    try {
      make();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const FixedPointForm form(values, values, 33);
  EXPECT_THROW(FixedPointForm(values, values, 0), std::invalid_argument);
  EXPECT_THROW(FixedPointForm(values, values, 7), std::invalid_argument);
  EXPECT_THROW(FixedPointForm(values, values, 4097), std::invalid_argument);
  EXPECT_THROW(FixedPointDescriptors(std::span(values).first(65), form), std::invalid_argument);
  const FixedPointDescriptors descriptors(values, form);
  EXPECT_THROW(BestMatches(descriptors, 9), std::invalid_argument);
  EXPECT_THROW(BestMatches(descriptors, 0), std::invalid_argument);

  const std::vector<float> ones = values;
  values[40] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(error_of([&] { FixedPointForm(ones, values, 33); }), "target: descriptor 1 is not finite");
  EXPECT_EQ(error_of([&] { FixedPointDescriptors(values, form); }).rfind("descriptor 1: component 7", 0), 0u);
  std::fill(values.begin() + 33, values.end(), 1.1f);
  EXPECT_EQ(error_of([&] { FixedPointDescriptors(values, form); }).rfind("descriptor 1 is longer than", 0), 0u);

  const FixedPointForm other(values, values, 33);
  const FixedPointDescriptors others(values, other);
  const std::vector<float> three(99, 1.0f);
  const FixedPointDescriptors more(three, form);
  BestMatches mine(descriptors, 2), theirs(others, 2), of_three(more, 2), nearest(descriptors, 1);
  EXPECT_THROW(best_matches(descriptors, others, mine, theirs), std::invalid_argument);
  EXPECT_THROW(best_matches(descriptors, more, mine, mine), std::invalid_argument);
  EXPECT_THROW(best_matches(descriptors, descriptors, mine, nearest), std::invalid_argument);
  EXPECT_THROW(best_matches(descriptors, more, mine, of_three, 2, 2), std::out_of_range);
  EXPECT_THROW(mine.merge(of_three), std::invalid_argument);
  EXPECT_THROW(mine.merge(nearest), std::invalid_argument);
}

TEST(FixedPointDescriptors, HaveListsOfTheirOwn) {
  std::vector<float> up(40), down(40);
  std::iota(up.begin(), up.end(), 0.0f);
  std::copy(up.rbegin(), up.rend(), down.begin());
  const FixedPointForm form(up, down, 1);
  const FixedPointDescriptors ascending(up, form), descending(down, form);
  BestMatches of_ascending(ascending, 1), of_descending(descending, 1);
  EXPECT_THROW(best_matches(ascending, descending, of_descending, of_descending), std::invalid_argument);
  EXPECT_THROW(best_matches(ascending, descending, of_ascending, of_ascending), std::invalid_argument);
  EXPECT_THROW(of_ascending.merge(of_descending), std::invalid_argument);
  best_matches(ascending, descending, of_ascending, of_descending);
  for (std::uint32_t i = 0; i < 40; ++i) EXPECT_EQ(of_ascending.index(i, 0), 39 - i);
}

}  // namespace
}  // namespace consimd::test
