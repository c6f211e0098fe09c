// Problems as text files that `consimd register` and any script can read.
#pragma once

#include <filesystem>

#include <consimd/synth/problem.hpp>

#pragma GCC visibility push(default)

namespace consimd::synth {

/// Writes three files to `folder`, which is made if need be:
///   correspondences.txt  N rows of source xyz and target xyz after a '#' line that names the columns
///   pose.txt             the true T_target_source, 4 x 4, its rotation multiplied by the scale: what maps the source
///   labels.txt           N rows, 1 for a true inlier, else 0
/// Numbers carry the digits (at most 17 significant ones) that read back as the same double.
/// Every file is written whole under a temporary name before the first is renamed, so a failure leaves nothing
/// half-written. Throws std::runtime_error naming the path.
void write_problem(const Problem& problem, const std::filesystem::path& folder);

}  // namespace consimd::synth

#pragma GCC visibility pop
