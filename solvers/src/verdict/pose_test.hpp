// What a pose that a search has found is held against.
#pragma once

#include <cstdint>
#include <functional>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// The best score of a pose that a search finds from at most `seeds` seeds.
using ScoreSearch = std::function<double(const Correspondences&, std::uint64_t seed, std::uint32_t seeds)>;

struct PoseTest {
  double noise_bound = 0.0;  ///< caller's unit
  std::uint64_t seed = 1;
  std::uint32_t bounds_tried = 1;  ///< that `noise_bound` was chosen from by looking at the data
  ScoreSearch search;              ///< repeated on random pairings where the closed form leaves doubt
};

}  // namespace consimd::detail
