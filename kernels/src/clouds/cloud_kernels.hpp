// The part of the table of functions that works on clouds and descriptors. Plain data only: this header is seen by
// every ISA-specific source.
#pragma once

#include <cstddef>
#include <cstdint>

#include <consimd/kernels/pair_block.hpp>
#include <consimd/kernels/point_run.hpp>

namespace consimd::detail {

/// A CloudView as bare pointers: NaN from `size` on, and readable for 64 floats more. Normals may be null where a
/// kernel does not read them.
struct RawPoints {
  const float* points[3];
  const float* normals[3];
  std::size_t size;
};

/// Descriptors that a tile holds.
inline constexpr std::size_t kTileSize = 16;
/// Queries that are compared with a tile at a time.
inline constexpr std::size_t kQueryGroup = 4;
/// Pairs of components after which distances are compared with what is wanted, before the others are looked at.
inline constexpr std::size_t kLeadingPairs = 4;
/// Components by which the boxes of tiles and of groups are told apart.
inline constexpr std::size_t kBoxed = 4;

/// Descriptors as whole numbers of `pairs` times two components, alike ones together.
struct RawDescriptors {
  const std::int16_t* rows;           ///< one after the other
  const std::int16_t* tiles;          ///< pair 0 of each of the tile, pair 1 of each, ...; the last filled up with 0
  const std::int32_t* squared_norms;  ///< up to the last tile's end
  const std::int32_t* leading_norms;  ///< squared, of the leading pairs alone
  const std::int32_t* numbers;        ///< what each is called in lists of matches
  const std::int32_t* lows;           ///< boxes of tiles: entry c * box_stride + t is the least component c of tile t
  const std::int32_t* highs;
  std::size_t box_stride;
  std::size_t size;
  std::size_t pairs;
};

inline constexpr std::size_t kMostMatches = 8;

/// The best k, kMostMatches at most, of each of a number of descriptors, rank by rank: entry r * stride + i is of rank
/// r of descriptor i. Ranks ascend by distance, then by number. Distances behind the last descriptor, up to its tile's
/// end, are -1, so that nothing is near enough for them.
struct RawMatches {
  std::int32_t* distances;
  std::int32_t* numbers;
  std::size_t stride;
};

/// Some of the groups of queries: the g-th begins with query first + g * step.
struct QueryGroups {
  std::size_t first;
  std::size_t step;
  std::size_t count;
};

/// Numbers that best_matches keeps meanwhile: a box and a tile for each group, a group and its distance for each tile.
struct MatchScratch {
  std::int32_t* boxes;
  std::int32_t* tiles_of_groups;
  std::int32_t* groups_of_tiles;
  std::int32_t* distances_of_tiles;
};

/// Every pointer is set in every table. No function allocates or throws.
struct CloudKernels {
  /// Those of the runs' points whose squared distance from `query` is at most the squared radius, in the order of the
  /// runs; indices, squared: room for all points of the runs and 16 more. Returns their number.
  std::size_t (*neighbours_within)(const RawPoints&, const float query[3], const PointRun* runs, std::size_t n,
                                   float radius, std::uint32_t* indices, float* squared);
  /// The `most` nearest to `query` of the runs' points whose squared distance is at most the squared radius, ascending
  /// by distance, then by index, whatever the order of the runs; most >= 1; indices, squared: `most` each. Returns
  /// their number. Of a point that is in two runs there are two.
  std::size_t (*nearest_within)(const RawPoints&, const float query[3], const PointRun* runs, std::size_t n,
                                float radius, std::size_t most, std::uint32_t* indices, float* squared);
  /// scatter: xx, xy, xz, yy, yz, zz of the points about their mean, in units of `unit` squared; n >= 1.
  void (*neighbourhood_scatter)(const RawPoints&, const float centre[3], const std::uint32_t* indices, std::size_t n,
                                float unit, float scatter[6]);
  /// scatter, axes, values: arrays of n, rounded up to a multiple of 16, aligned.
  void (*principal_axes)(const float* const scatter[6], std::size_t n, float* const axes[3], float* const values[3]);
  /// counts: 33.
  void (*pair_feature_counts)(const RawPoints&, std::uint32_t point, const std::uint32_t* indices, std::size_t n,
                              std::uint32_t* counts);
  /// histograms: rows of 48 floats, aligned; sum: 48, aligned.
  void (*weighted_histogram_sum)(const float* histograms, const std::uint32_t* rows, const float* squared,
                                 std::size_t n, float* sum);
  /// Enters the distances between a part of the queries and all targets into the best k of both; k >= 1.
  void (*best_matches)(const RawDescriptors& queries, const QueryGroups&, const RawDescriptors& targets, std::size_t k,
                       const RawMatches& of_queries, const RawMatches& of_targets, const MatchScratch&);
  /// stale: PairBlock::kSize bits.
  void (*move_pairs)(PairBlock&, std::size_t n, const WorkingMotion&, std::uint64_t* stale);
  void (*pair_residuals)(const RawPoints& target, const PairBlock&, std::size_t n, const PairProblem&, float* squared);
  void (*pair_equations)(const RawPoints& target, const PairBlock&, std::size_t n, const PairProblem&, PairEquations&);
};

/// Distances in the working frame, whose coordinates are at most 1, are known to about this.
inline constexpr float kDistanceRounding = 0x1p-21f;
/// Cauchy's constant, in deviations, of 95 % efficiency for Gaussian residuals.
inline constexpr float kCauchy = 2.3849f;
/// Variance along a normal over that across, as PairMetric::gicp has it.
inline constexpr float kAlongNormal = 1e-3f;

/// Bins of each of the three pair features.
inline constexpr std::size_t kFeatureBins = 11;

/// Borders of the bins on either side of the middle one: squares of 1/11, 3/11, ..., 9/11, and sines and cosines of
/// these shares of pi.
inline constexpr float kSquaredShares[5] = {1.0f / 121.0f, 9.0f / 121.0f, 25.0f / 121.0f, 49.0f / 121.0f,
                                            81.0f / 121.0f};
inline constexpr float kSines[5] = {0.281732557f, 0.755749574f, 0.989821442f, 0.909631995f, 0.540640817f};
inline constexpr float kCosines[5] = {0.959492974f, 0.654860734f, 0.142314838f, -0.415415013f, -0.841253533f};

namespace scalar {
std::size_t neighbours_within(const RawPoints&, const float query[3], const PointRun* runs, std::size_t n, float radius,
                              std::uint32_t* indices, float* squared);
std::size_t nearest_within(const RawPoints&, const float query[3], const PointRun* runs, std::size_t n, float radius,
                           std::size_t most, std::uint32_t* indices, float* squared);
void neighbourhood_scatter(const RawPoints&, const float centre[3], const std::uint32_t* indices, std::size_t n,
                           float unit, float scatter[6]);
void principal_axes(const float* const scatter[6], std::size_t n, float* const axes[3], float* const values[3]);
void pair_feature_counts(const RawPoints&, std::uint32_t point, const std::uint32_t* indices, std::size_t n,
                         std::uint32_t* counts);
void weighted_histogram_sum(const float* histograms, const std::uint32_t* rows, const float* squared, std::size_t n,
                            float* sum);
void best_matches(const RawDescriptors& queries, const QueryGroups&, const RawDescriptors& targets, std::size_t k,
                  const RawMatches& of_queries, const RawMatches& of_targets, const MatchScratch&);
void move_pairs(PairBlock&, std::size_t n, const WorkingMotion&, std::uint64_t* stale);
void pair_residuals(const RawPoints& target, const PairBlock&, std::size_t n, const PairProblem&, float* squared);
void pair_equations(const RawPoints& target, const PairBlock&, std::size_t n, const PairProblem&, PairEquations&);

inline constexpr CloudKernels kCloudKernels{
    .neighbours_within = neighbours_within,
    .nearest_within = nearest_within,
    .neighbourhood_scatter = neighbourhood_scatter,
    .principal_axes = principal_axes,
    .pair_feature_counts = pair_feature_counts,
    .weighted_histogram_sum = weighted_histogram_sum,
    .best_matches = best_matches,
    .move_pairs = move_pairs,
    .pair_residuals = pair_residuals,
    .pair_equations = pair_equations,
};
}  // namespace scalar

}  // namespace consimd::detail
