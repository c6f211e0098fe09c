// The two filters of TCF before any solver: the paper's "Boosting Performance with TCF".
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>

namespace CONSIMD_EXPORT consimd {

struct TcfFilterOptions {
  double noise_bound = 0.0;               ///< tau, caller's unit; finite and > 0. Lengths may differ by 2 tau
  double confidence = 0.99;               ///< of each stage, see one_point_ransac.hpp
  std::uint32_t max_iterations = 10'000;  ///< of each stage
  std::uint64_t seed = 1;
};

struct FilteredRows {
  std::vector<std::uint32_t> rows;  ///< kept rows of the input, ascending; all of fewer than two
  bool confident = true;            ///< neither stage ran into max_iterations
  std::vector<StageReport> stages;  ///< "filter_one_point", "filter_two_point"
};

/// One-point RANSAC on length consistency, then two-point RANSAC on length and angle consistency, both with the
/// stages' defaults. Keeps one set of correspondences that agree pairwise, usually those of the true pose. Throws
/// std::invalid_argument on a bad option.
[[nodiscard]] FilteredRows tcf_filter(const Correspondences& correspondences, const TcfFilterOptions& options);

}  // namespace consimd
