// Reduction of a consensus set to the members that agree with one another.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "search/tcf_tuning.hpp"

namespace consimd::detail {

/// What a member of a set is worth.
enum class Merit : std::uint8_t {
  degree,  ///< its degree within the set
  excess,  ///< what that degree exceeds chance by: correspondences near the middle of both clouds are consistent with
           ///< many others. For sets that are a small part of the matrix
};

/// Scratch of `prune`, kept between calls.
struct PruneScratch {
  std::vector<std::uint64_t> set;
  std::vector<std::uint32_t> degrees;
  std::vector<std::uint32_t> histogram;
};

/// Shrinks `members` (rows of `matrix`, ascending) in rounds: with E the number of consistent ordered pairs within the
/// set, self pairs counted, only the m = ceil(sqrt(E)) members of highest merit stay (ties: the lower
/// row), until a round drops few; by excess, only a part of them of a large set. m bounds the
/// size of any clique in the set: when it shows that there is none of `give_up_below` members, `members` comes back
/// empty.
void prune(const ConsistencyMatrix& matrix, std::vector<std::uint32_t>& members, std::uint32_t give_up_below,
           Merit merit, const PruningTuning& tuning, PruneScratch& scratch);

/// Prunes sets given as rows of a `Correspondences`, by the consistency matrix of each set alone. Holds the memory that
/// takes.
class SetPruner {
 public:
  /// As `prune` above for `set`, rows of `correspondences`; a set that is given up is cleared.
  void prune(const Correspondences& correspondences, std::vector<std::uint32_t>& set, double consistency_bound,
             std::uint32_t give_up_below, const PruningTuning& tuning = {});

 private:
  PruneScratch scratch_;
  Correspondences subset_;
  ConsistencyMatrix matrix_;
  std::vector<std::uint32_t> local_;
};

}  // namespace consimd::detail
