// The default TCF with other constants than its own.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/tcf.hpp>

#include "search/tcf_tuning.hpp"

namespace consimd::detail {

/// As register_tcf, which calls it with the tuning as constructed.
Registration register_tuned_tcf(const Correspondences& correspondences, const TcfOptions& options,
                                const TcfTuning& tuning);

}  // namespace consimd::detail
