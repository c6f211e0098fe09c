// Rows as people have them: what a nuisance adds to a problem changes nothing of what is found.
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/field_problems.hpp>
#include <consimd/synth/hard_problems.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

using synth::FarSide;

constexpr std::array kSides{FarSide::source, FarSide::target, FarSide::both};

/// A problem with a nuisance and the same without it.
struct Nuisance {
  const char* name;
  Problem (*without)(std::uint64_t trial);
  Problem (*with)(std::uint64_t trial);
  double bound_without;
  double bound_with;
  Status expected = Status::success;
};

void PrintTo(const Nuisance& nuisance, std::ostream* out) { *out << nuisance.name; }

Problem forty_rows(std::uint64_t trial) {
  return synth::hard_problem(
      {.correspondences = 40, .outlier_ratio = 0.2, .sigma = 0.01, .half_extent = 50.0, .trial = trial});
}

/// As many far rows, 20 to 200 times as far away as all else, as are still fewer than the inliers: they fit the frame.
Problem forty_rows_and_far_ones(std::uint64_t trial) {
  return synth::with_far_rows(
      forty_rows(trial),
      {.rows = 25, .distance = 1e4, .side = kSides[trial % 3], .coincident = trial % 2 == 0, .trial = trial});
}

Problem forty_rows_and_some_without_depth(std::uint64_t trial) {
  return synth::with_rows_without_depth(forty_rows(trial), 12 + trial % 24, 1, trial);
}

/// As many rows of one "no value" as there are others, up to four times as many, on one side or both.
Problem forty_rows_and_more_without_value(std::uint64_t trial) {
  constexpr std::array kValues{9999.0, 65535.0, 1e10, std::numeric_limits<double>::max()};
  return synth::with_far_rows(forty_rows(trial), {.rows = 40 + trial % 120,
                                                  .distance = kValues[trial % 4],
                                                  .side = kSides[trial % 3],
                                                  .coincident = true,
                                                  .trial = trial});
}

/// Two values stand for none, as pixels without depth and pixels out of range have them: each in fewer rows than there
/// are others, or up to twice as many.
Problem forty_rows_and_more_without_either_value(std::uint64_t trial) {
  constexpr std::array kValues{9999.0, 65535.0, 1e10};
  Problem problem = forty_rows(trial);
  for (std::uint64_t k = 0; k < 2; ++k) {
    problem = synth::with_far_rows(problem, {.rows = 24 + trial % 56,
                                             .distance = kValues[(trial + k) % 3],
                                             .side = kSides[trial % 3],
                                             .coincident = true,
                                             .trial = trial + k});
  }
  return problem;
}

/// Two to five values in all three coordinates, each in up to twice as many rows as there are others, on sides of its
/// own.
Problem forty_rows_and_many_no_values(std::uint64_t trial) {
  constexpr std::array kValues{-9999.0, 65535.0, -32768.0, 1e38, 9999.0, 1e10};
  std::mt19937_64 random(trial);
  std::uniform_real_distribution<double> coordinate(-50.0, 50.0);
  Problem problem = forty_rows(trial);
  for (std::uint64_t k = 0; k < 2 + trial % 4; ++k) {
    const double value = kValues[(trial + k) % kValues.size()];
    const FarSide side = kSides[random() % 3];
    for (std::uint64_t row = 24 + random() % 56; row > 0; --row) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        problem.source.push_back(side == FarSide::target ? coordinate(random) : value);
        problem.target.push_back(side == FarSide::source ? coordinate(random) : value);
      }
      problem.is_inlier.push_back(0);
    }
  }
  return problem;
}

Problem forty_rows_and_more_without_depth(std::uint64_t trial) {
  return synth::with_rows_without_depth(forty_rows(trial), 40 + trial % 120, 1, trial);
}

/// One to five wrong matches that 30 to 120 frames have again, each a little elsewhere in either cloud.
Problem forty_rows_and_recurring_places(std::uint64_t trial) {
  std::mt19937_64 random(trial);
  std::normal_distribution<double> jitter(0.0, 0.005);
  Problem problem = forty_rows(trial);
  std::size_t place = 0;
  for (std::uint64_t k = 0; k <= trial % 5; ++k) {
    while (problem.is_inlier[place] != 0) ++place;  // one in five is wrong
    for (std::uint64_t frame = 30 + random() % 90; frame > 0; --frame) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        problem.source.push_back(problem.source[3 * place + axis] + jitter(random));
        problem.target.push_back(problem.target[3 * place + axis] + jitter(random));
      }
      problem.is_inlier.push_back(0);
    }
    ++place;
  }
  return problem;
}

/// Twenty rows up to 1e4 to 1e9 away, two or three times each.
Problem forty_rows_and_copied_far_ones(std::uint64_t trial) {
  const Problem bare = forty_rows(trial);
  const Problem problem = synth::with_far_rows(
      bare,
      {.rows = 20, .distance = std::array{1e4, 1e6, 1e9}[trial % 3], .side = kSides[trial / 3 % 3], .trial = trial});
  Problem copied = problem;
  std::size_t next = 0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    if (next < bare.size() && source_point(problem, k) == source_point(bare, next) &&
        target_point(problem, k) == target_point(bare, next)) {
      ++next;
      continue;
    }
    for (std::uint64_t copy = 0; copy <= trial % 2; ++copy) {
      copied.source.insert(copied.source.end(), &problem.source[3 * k], &problem.source[3 * k] + 3);
      copied.target.insert(copied.target.end(), &problem.target[3 * k], &problem.target[3 * k] + 3);
      copied.is_inlier.push_back(0);
    }
  }
  return copied;
}

/// Up to twice as many rows of which one coordinate of one cloud is a value for none.
Problem forty_rows_and_more_without_a_coordinate(std::uint64_t trial) {
  std::mt19937_64 random(trial);
  std::uniform_real_distribution<double> coordinate(-50.0, 50.0);
  const double value = std::array{-9999.0, 65535.0, 1e10}[trial % 3];
  Problem problem = forty_rows(trial);
  std::vector<double>& cloud = trial % 2 == 0 ? problem.source : problem.target;
  for (std::uint64_t row = 20 + random() % 60; row > 0; --row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      problem.source.push_back(coordinate(random));
      problem.target.push_back(coordinate(random));
    }
    cloud.back() = value;
    problem.is_inlier.push_back(0);
  }
  return problem;
}

Problem targets(std::uint64_t trial, std::size_t frames, bool copied) {
  return synth::repeated_targets(
      {.targets = 10 + trial % 10, .frames = frames, .blunders = 0.2, .copied = copied, .trial = trial});
}
Problem targets_once(std::uint64_t trial) { return targets(trial, 1, true); }
Problem targets_copied(std::uint64_t trial) { return targets(trial, 2 + trial % 8, true); }
Problem targets_measured_again(std::uint64_t trial) { return targets(trial, 2 + trial % 8, false); }

Problem landmarks(std::uint64_t trial) { return synth::all_to_all({.landmarks = 16 + trial % 8, .trial = trial}); }
Problem gear(std::uint64_t trial) {
  return synth::symmetric_part({.folds = 6 + trial % 4, .points_per_sector = 8, .sigma = 0.0005, .trial = trial});
}

Problem only_inliers(const Problem& problem) { return chosen_rows(problem, true_inliers(problem)); }
Problem known_landmarks(std::uint64_t trial) { return only_inliers(landmarks(trial)); }
Problem marked_gear(std::uint64_t trial) { return only_inliers(gear(trial)); }

/// 4 to 30 rows, a quarter of them wrong.
Problem few_rows(std::uint64_t trial) {
  return synth::hard_problem(
      {.correspondences = 4 + trial % 27, .outlier_ratio = 0.25, .sigma = 0.01, .half_extent = 10.0, .trial = trial});
}
Problem few_right_rows(std::uint64_t trial) { return only_inliers(few_rows(trial)); }

Problem exact(std::uint64_t trial) {
  return synth::hard_problem(
      {.correspondences = 60, .outlier_ratio = 0.5, .sigma = 0.0, .half_extent = 50.0, .trial = trial});
}

/// The deviation of numbers that are rounded to multiples of 0.5 on both sides is 0.5 / sqrt(6).
Problem noisy(std::uint64_t trial) {
  return synth::hard_problem(
      {.correspondences = 300, .outlier_ratio = 0.8, .sigma = 0.204, .half_extent = 15.0, .trial = trial});
}
Problem quantised(std::uint64_t trial) {
  return synth::hard_problem({.correspondences = 300,
                              .outlier_ratio = 0.8,
                              .sigma = 0.0,
                              .half_extent = 15.0,
                              .trial = trial,
                              .quantum = 0.5});
}

/// Each kind has a thousand problems, a third of them without a bound too, which the solvers take in turn.
class Nuisances : public ::testing::TestWithParam<Nuisance> {};

INSTANTIATE_TEST_SUITE_P(
    Kinds, Nuisances,
    ::testing::Values(Nuisance{"far_rows", forty_rows, forty_rows_and_far_ones, 0.05, 0.05},
                      Nuisance{"rows_without_depth", forty_rows, forty_rows_and_some_without_depth, 0.05, 0.05},
                      Nuisance{"most_rows_without_depth", forty_rows, forty_rows_and_more_without_depth, 0.05, 0.05},
                      Nuisance{"most_rows_without_value", forty_rows, forty_rows_and_more_without_value, 0.05, 0.05},
                      Nuisance{"most_rows_without_either_value", forty_rows, forty_rows_and_more_without_either_value,
                               0.05, 0.05},
                      Nuisance{"many_no_values", forty_rows, forty_rows_and_many_no_values, 0.05, 0.05},
                      Nuisance{"recurring_places", forty_rows, forty_rows_and_recurring_places, 0.05, 0.05},
                      Nuisance{"copied_far_rows", forty_rows, forty_rows_and_copied_far_ones, 0.05, 0.05},
                      Nuisance{"a_coordinate_lost", forty_rows, forty_rows_and_more_without_a_coordinate, 0.05, 0.05},
                      Nuisance{"copies", targets_once, targets_copied, 0.05, 0.05},
                      Nuisance{"targets_in_frames", targets_once, targets_measured_again, 0.05, 0.05},
                      Nuisance{"all_to_all", known_landmarks, landmarks, 0.3, 0.3},
                      Nuisance{"blunders_in_small_sets", few_right_rows, few_rows, 0.03, 0.03},
                      Nuisance{"quantised", noisy, quantised, 0.6, 0.6},
                      Nuisance{"exact_under_tiny_bounds", exact, exact, 1e-3, 1e-13},
                      Nuisance{"symmetric_parts", marked_gear, gear, 0.0015, 0.0015, Status::ambiguous}),
    [](const auto& test) { return std::string(test.param.name); });

/// How the problems of a kind end beside those without the nuisance.
struct Tally {
  std::size_t lost = 0;
  std::size_t won = 0;
  std::size_t wrong = 0;
};

Tally tally(const Nuisance& kind, bool bound_is_known, std::uint64_t trials) {
  Tally result;
  for (std::uint64_t trial = 0; trial < trials; ++trial) {
    const char* solver = kSolvers[trial % kSolvers.size()];
    const auto found = [&](const Problem& problem, double bound) {
      return register_by_name(solver, problem.correspondences(),
                              {.noise_bound = bound_is_known ? std::optional(bound) : std::nullopt, .seed = trial});
    };
    const Problem bare = kind.without(trial);
    const Problem problem = kind.with(trial);
    const Registration with = found(problem, kind.bound_with);
    const bool right_without = is_right(bare, found(bare, kind.bound_without), kind.bound_without);
    const bool right = kind.expected == Status::ambiguous
                           ? with.status == kind.expected
                           : is_right(problem, with, std::max(kind.bound_with, problem.correspondences().resolution()));
    result.lost += right_without && !right ? 1U : 0U;
    result.won += right && !right_without ? 1U : 0U;
    result.wrong += with.status == Status::success && !right ? 1U : 0U;
  }
  return result;
}

// Were neither likelier, 3.1 deviations of the difference would be exceeded once in a thousand runs.
double most_lost(const Tally& tally) {
  return static_cast<double>(tally.won) + 3.1 * std::sqrt(static_cast<double>(tally.lost + tally.won));
}

TEST_P(Nuisances, CostNoSolverAPose) {
  const Tally found = tally(GetParam(), true, trials(1001));
  EXPECT_LE(static_cast<double>(found.lost), most_lost(found));
  EXPECT_LE(found.wrong, 1U);
}

TEST_P(Nuisances, CostNoPoseWithoutABound) {
  const Tally found = tally(GetParam(), false, trials(301));  // each takes several times as long
  EXPECT_LE(static_cast<double>(found.lost), most_lost(found));
  EXPECT_LE(found.wrong, 1U);
}

}  // namespace
}  // namespace consimd::test
