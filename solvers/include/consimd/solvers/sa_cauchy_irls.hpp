// Scale-adaptive Cauchy IRLS: the fine pose of TCF (algorithm 3 of the paper).
#pragma once

#include <span>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace CONSIMD_EXPORT consimd {

struct SaCauchyIrlsOptions {
  /// How the iteration is weighted and stopped.
  enum class Rule : std::uint8_t {
    scale_free,  ///< weights g^2 / (g^2 + e^2); g shrinks until it reaches `final_scale`, the same in every unit
    as_printed,  ///< algorithm 3 to the letter, in metres: weights g^2 / (g^2 + e); stop when the cost changes by less
                 ///< than 0.01 or g < 1
  };
  Rule rule = Rule::scale_free;
  double final_scale = 0.0;    ///< caller's unit, > 0; scale_free only. The noise bound is a good choice
  double scale_divisor = 1.3;  ///< mu, > 1
  std::uint32_t max_rounds = 100;
};

struct IrlsResult {
  RigidFit fit;                        ///< working frame
  std::vector<std::uint32_t> members;  ///< members within 3 g of the last round
  std::uint32_t rounds = 0;
};

/// Starts from equal weights on all members, g = their largest residual, and lowers g by `scale_divisor` a round.
/// members: rows of `correspondences`. Throws std::invalid_argument on a bad option.
[[nodiscard]] IrlsResult sa_cauchy_irls(const Correspondences& correspondences, std::span<const std::uint32_t> members,
                                        const SaCauchyIrlsOptions& options);

}  // namespace consimd
