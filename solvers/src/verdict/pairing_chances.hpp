// What pairing sources and targets at random would give, measured on the correspondences at hand.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "support/repeated_points.hpp"

namespace consimd::detail {

/// Laplace's estimate of a chance that gave `hits` in `trials`.
inline double chance(double hits, double trials) { return (hits + 1.0) / (trials + 2.0); }

/// Among so many correspondences chances follow Laplace's rule, and all pairs are soon looked at.
inline constexpr std::size_t kFewCorrespondences = 512;

/// How a chance is told where pairings give hardly any hits.
enum class RareHits : std::uint8_t {
  laplace,       ///< as if there had been one more: never too little
  extrapolated,  ///< from how their number grows with the bound further out; among a few correspondences as above, from
                 ///< all pairs of them
};

/// Chances that the pose takes a source within each of `bounds` (caller's unit, descending) of the target of any other
/// correspondence: from `shifts` pairings of all of them, or from as many as there are where these are fewer or, of few
/// correspondences, where chances are to be extrapolated. `matched` at the pose are no chance.
std::vector<double> pose_chances(const CorrespondenceView& view, const WorkingPose& pose,
                                 std::span<const double> bounds, std::uint32_t shifts, RareHits rare,
                                 const MatchedPoints& matched);

/// Chance that two correspondences agree in length, from as many `pairs` drawn.
class LengthChance {
 public:
  /// `explained`, ascending: rows whose agreement with one another is what the chance is held against.
  LengthChance(const CorrespondenceView& view, std::span<const std::uint32_t> explained, std::uint32_t pairs,
               std::uint64_t seed);

  /// Within `bound`, caller's unit: the larger of the shares among mismatched pairs and, but for those between rows
  /// that are explained, among pairs as they are.
  [[nodiscard]] double operator()(double bound) const;

 private:
  double scale_;
  double pairs_;                    // of different correspondences
  std::vector<double> own_;         // differences of lengths, working frame
  std::vector<double> mismatched_;  // the same
};

}  // namespace consimd::detail
