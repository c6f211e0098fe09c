// The rows that a solver works on: what is far from all others or a copy is no evidence of its own.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// The correspondences without far rows (see Correspondences) and without copies: of rows that are equal in both
/// points, to the precision of the working frame, the first one counts. So neither changes what a solver finds.
class DistinctRows {
 public:
  /// Keeps a reference to the correspondences. Takes a few nanoseconds a row.
  explicit DistinctRows(const Correspondences& all);

  /// In the order and the working frame of all; these themselves, where they are distinct.
  [[nodiscard]] const Correspondences& correspondences() const noexcept { return chosen_.empty() ? all_ : distinct_; }
  /// Makes `rows`, ascending, of correspondences() the rows of all that they and their copies are, ascending.
  void restore(std::vector<std::uint32_t>& rows) const;

 private:
  const Correspondences& all_;
  std::vector<std::uint32_t> chosen_;    // rows of all; empty: all of them
  std::vector<std::uint32_t> position_;  // in chosen_, of each row of all; that of no row where it is far
  Correspondences distinct_;
};

}  // namespace consimd::detail
