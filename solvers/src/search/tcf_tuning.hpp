// The constants of the default search, by stage.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace consimd::detail {

/// Which seeds are looked at together.
struct RoundTuning {
  /// Rounds of seeds grow from the first to the last size: few for easy problems, enough to keep many threads busy in
  /// hard ones.
  std::uint32_t first = 4;
  std::uint32_t largest = 64;
  /// Sets tried first in a round; the others must promise more than what these gave.
  std::size_t first_wave = 2;
};

/// The rows that a seed is tested against.
struct WindowTuning {
  /// Members of a set that a window should show, about, and the window of the first round, whose sets may have any
  /// size. A window is kept while it is wrong by less than the slack.
  double shown = 80.0;
  std::size_t first = 1024;
  double slack = 1.5;
  /// Share of all pairs that are consistent from which samples of sets tell too little, and the matrix of a window is
  /// better than one matrix per set.
  double dense = 0.15;
  /// Rows of that matrix. Where the budget allows only fewer than the least there is none.
  std::size_t largest_matrix = 3072;
  std::size_t least_matrix = 512;
};

/// How large a clique a set is taken for, and which sets are pruned at all.
struct TwoPointTuning {
  /// A set is sampled with this many members, of which this many are tried as the second point.
  std::size_t sample = 64;
  std::size_t partners = 16;
  /// Second points tried by the matrix, about. 0: none, a set is judged by its size.
  std::size_t matrix_partners = 48;
  /// Guesses scatter: sets down to these shares of the best guess, and of the support to beat, are kept.
  float slack = 0.5F;
  float support_slack = 0.8F;
  /// Sets whose guess is below this quantile of all guesses so far look like those of outliers, unless one row in
  /// `many_inliers` supports the best pose: the usual set may be that of an inlier then. 0: none do.
  double unusual = 0.88;
  std::size_t many_inliers = 8;
  /// Larger sets are reduced by a second point.
  std::uint32_t second_point = 96;
  /// Largest set whose own matrix is built; larger ones are thinned evenly.
  std::size_t largest_set = 160;
  /// Poses through a seed and its second point that tell whether its set may hold a rival of a settled pose, and the
  /// least score of the best of them, as a share of the support wanted.
  std::size_t glances = 16;
  double glance_share = 0.1;
};

/// See `prune`.
struct PruningTuning {
  std::uint32_t smallest_drop = 5;
  /// In a large set pruned by excess only this share of what its bound allows stays in a round: merits tell so well
  /// that a clique far smaller than the bound survives.
  double large_kept = 0.5;
  std::uint32_t large = 256;
};

/// Poses of pruned sets.
struct ThreePointTuning {
  /// Minimal fits drawn from each set, at most, and the first of them. The others are tried if these give a score
  /// within the set of some share of the support to beat, and are not needed once a share of the set agrees.
  std::uint32_t triples = 160;
  std::uint32_t first_triples = 48;
  float support_share = 0.3F;
  float enough_share = 0.2F;
};

/// Values at run time, so that bench/tuning can tell what each of them is worth (docs/tcf.md).
struct TcfTuning {
  RoundTuning round;
  WindowTuning window;
  TwoPointTuning two_point;
  PruningTuning pruning;
  ThreePointTuning three_point;
};

/// For a search that has found nothing: windows of all rows, their matrix, of 8 MB at most, sooner, sets not reduced by
/// a second point, none dropped for what a sample says of it. A matrix of all rows took 2.5 to 6 times as long for 20
/// 000 rows without a pose, and 72 of 73 problems near the limit were found with it, 70 with this one
/// (docs/performance.md).
inline TcfTuning with_care(TcfTuning tuning) {
  tuning.window.shown = std::numeric_limits<double>::infinity();
  tuning.window.first = std::numeric_limits<std::size_t>::max();
  tuning.window.largest_matrix = 8192;
  tuning.window.dense = 0.085;
  tuning.two_point.matrix_partners = 0;
  tuning.two_point.unusual = 0.0;
  tuning.two_point.second_point = std::numeric_limits<std::uint32_t>::max();
  tuning.two_point.largest_set = 256;
  return tuning;
}

}  // namespace consimd::detail
