// Correspondences from descriptors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

struct MatchOptions {
  /// Matches that each descriptor is considered for: the `best` nearest, 1 to 8.
  std::size_t best = 3;
  /// Keep a match only where it is among the best of both descriptors ("rank in each other's top three" in the paper).
  bool mutual = true;
  /// Keep a source descriptor's matches only where the nearest target is nearer than this share of the distance of the
  /// second nearest (Lowe's ratio test); above 0, 1 keeps all.
  double ratio = 1.0;
  /// More distances than this are refused: 2e11 take a core about a minute.
  double most_distances = 2e11;
};

struct Match {
  std::uint32_t source = 0;  ///< descriptor of the source
  std::uint32_t target = 0;  ///< descriptor of the target
  float distance = 0.0f;     ///< between them, in their own unit
};

/// Matches by Euclidean distance, by source descriptor, nearest first. source, target: rows of `length` numbers, any
/// descriptors (FPFH, learned ones). As if all distances were computed, in fixed point (see descriptor_matches.hpp), in
/// memory that grows with the number of descriptors alone; of equally near descriptors the earlier one counts as
/// nearer. In parallel; the same for any number of threads and instruction set. Throws std::invalid_argument on bad
/// options, on a size that is no multiple of the length, on values that are not finite, and where there are more than
/// `most_distances` pairs.
[[nodiscard]] std::vector<Match> match(std::span<const float> source, std::span<const float> target, std::size_t length,
                                       const MatchOptions& options = {});

}  // namespace features
}  // namespace consimd
