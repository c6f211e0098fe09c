// What is known of a registration beside its numbers.
#pragma once

#include <string>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/assumed_inliers.hpp>
#include <consimd/solvers/registration.hpp>

namespace CONSIMD_EXPORT consimd {

/// Sentences for people, each without a full stop; most often none. They tell of rows far from all others and of a
/// noise bound that was raised; and where no pose was found, of a mirror image, of pair lengths that agree on another
/// scale (searched with pcr99 among up to 1024 rows, some tenths of a second), and of rows too few for any evidence,
/// which `register_assumed_inliers` takes all the same. Options have the names of the library, which those of the
/// command follow. The same for any number of threads and every ISA.
[[nodiscard]] std::vector<std::string> advice(const Correspondences& correspondences, const Registration& result);

/// Sentences of rows that are all assumed to be right. They tell what the points leave free, and another scale or a
/// reflection that fits far better.
[[nodiscard]] std::vector<std::string> advice(const AssumedInliers& result);

}  // namespace consimd
