// TCF as printed in the paper.
#pragma once

#include <consimd/solvers/tcf.hpp>

namespace consimd::detail {

/// Algorithms 1 to 4 of the paper one after the other, each on what the one before kept. Fills status, pose, inliers
/// and stages.
void register_tcf_published(const Correspondences& correspondences, const TcfOptions& options, Registration& result);

}  // namespace consimd::detail
