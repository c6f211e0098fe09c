// Mutual nearest neighbours among descriptors, as correspondences are made of keypoints.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace consimd::synth {

/// How a keypoint looks: descriptors of different kinds are no match, others are as similar as they are near.
struct Descriptor {
  std::uint8_t kind;
  std::array<float, 3> look;
};

struct Match {
  std::uint32_t source;
  std::uint32_t target;
};

/// The pairs of descriptors that are among each other's `k` nearest, k from 1 to 8; ascending by source, then target.
/// Among equally near ones the lower index comes first.
[[nodiscard]] std::vector<Match> mutual_matches(std::span<const Descriptor> source, std::span<const Descriptor> target,
                                                std::size_t k);

}  // namespace consimd::synth
