// Registrations held against one another and against the truth.
#pragma once

#include <consimd/solvers/registration.hpp>
#include <consimd/synth/metrics.hpp>

#include <gtest/gtest.h>

#include "problems.hpp"

namespace consimd::test {

/// Everything of a registration that must not vary with threads or instruction sets.
inline void expect_same(const Registration& a, const Registration& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.T_target_source.matrix(), b.T_target_source.matrix());
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.log10_false_poses, b.log10_false_poses);
  ASSERT_EQ(a.runner_up.has_value(), b.runner_up.has_value());
  if (a.runner_up) {
    EXPECT_EQ(a.runner_up->T_target_source.matrix(), b.runner_up->T_target_source.matrix());
    EXPECT_EQ(a.runner_up->support, b.runner_up->support);
    EXPECT_EQ(a.runner_up->log10_false_poses, b.runner_up->log10_false_poses);
  }
  ASSERT_EQ(a.stages.size(), b.stages.size());
  for (std::size_t s = 0; s < a.stages.size(); ++s) {
    EXPECT_EQ(a.stages[s].name, b.stages[s].name);
    EXPECT_EQ(a.stages[s].output, b.stages[s].output);
    EXPECT_EQ(a.stages[s].iterations, b.stages[s].iterations);
  }
}

inline bool succeeds(const Problem& problem, const Registration& result, double noise_bound) {
  return result.has_pose() && synth::rmse_true_inliers(problem, result.T_target_source) < noise_bound;
}

}  // namespace consimd::test
