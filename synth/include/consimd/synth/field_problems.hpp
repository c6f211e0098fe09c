// What people's rows bring with them that no noise is: far rows, pixels without depth, targets seen again in many
// frames, landmarks matched with all others, symmetric parts. Quantised coordinates, copies and small sets are options
// of `hard_problem`.
#pragma once

#include <cstddef>
#include <cstdint>

#include <consimd/kernels/export.hpp>
#include <consimd/synth/problem.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

// Points of all problems lie in the cube [-half_extent, half_extent]^3, motions turn uniformly and move by as much as
// that along each axis; rows come in random order. Lengths share one unit. Every function throws std::invalid_argument
// on an option outside its range.

/// Which points of a far row are far.
enum class FarSide : std::uint8_t { source, target, both };

struct FarRowOptions {
  std::size_t rows = 1;   ///< [0, 2^31)
  double distance = 1e6;  ///< of the far points from the origin, at most; > 0. The largest double is one
  FarSide side = FarSide::both;
  bool coincident = false;  ///< at one place, as "no value" is; otherwise in random directions, at a tenth of the
                            ///< distance or more
  std::uint64_t seed = 1;
  std::uint64_t trial = 0;
};

/// The problem with so many outliers more, at random places among its rows. A point of theirs that is not far is that
/// of a random row.
[[nodiscard]] Problem with_far_rows(const Problem& problem, const FarRowOptions& options);

/// The problem with so many rows 0 0 0 0 0 0 more, at random places: what pixels without depth give. rows: [0, 2^31).
[[nodiscard]] Problem with_rows_without_depth(const Problem& problem, std::size_t rows, std::uint64_t seed = 1,
                                              std::uint64_t trial = 0);

struct RepeatedTargetOptions {
  std::size_t targets = 10;  ///< [3, 2^16)
  std::size_t frames = 3;    ///< in which each of them is seen, [1, 2^15)
  double blunders = 0.0;     ///< share of the targets that have a wrong counterpart in all frames, [0, 1]
  bool copied = true;        ///< measured once: frames repeat the rows; otherwise measured in each frame anew
  double sigma = 0.01;       ///< of a measurement, per axis, in both clouds; >= 0
  double half_extent = 2.0;  ///< > 0
  std::uint64_t seed = 1;
  std::uint64_t trial = 0;
};

/// A surveyor's targets or a calibration board in many frames.
[[nodiscard]] Problem repeated_targets(const RepeatedTargetOptions& options);

struct AllToAllOptions {
  std::size_t landmarks = 40;  ///< in each cloud, [3, 2^11)
  double missing = 0.1;        ///< share of them that have no counterpart in the other cloud, [0, 1]
  double sigma = 0.1;          ///< of a target, per axis; >= 0
  double half_extent = 100.0;  ///< > 0
  std::uint64_t seed = 1;
  std::uint64_t trial = 0;
};

/// Every landmark of a cloud matched with every one of the other, for want of descriptors.
[[nodiscard]] Problem all_to_all(const AllToAllOptions& options);

struct SymmetricPartOptions {
  std::size_t folds = 6;  ///< the part is its own image after a turn by a full circle over these, [2, 2^10)
  std::size_t points_per_sector = 20;  ///< [3, 2^16)
  double sigma = 0.001;                ///< of a target, per axis; >= 0
  double half_extent = 0.3;            ///< > 0
  std::uint64_t seed = 1;
  std::uint64_t trial = 0;
};

/// A bottle, a gear: each point of a part matched with all its images under the turns that it is symmetric to. All of
/// `folds` poses are equally true; the labels and the pose are of one of them, the decoy pose is the next.
[[nodiscard]] Problem symmetric_part(const SymmetricPartOptions& options);

}  // namespace synth
}  // namespace consimd
