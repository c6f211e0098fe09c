// Registers benchmarks of whole registrations, single thread.
#pragma once

namespace consimd::bench {

/// SOLVER/noise/outliers:R/sigma:S on cells of the noise study, and SOLVER/pair/CASE on the recorded pairs (see
/// registration_tasks.hpp). A SOLVER is register_tcf with its default options, register_eigen, the plain Eigen code of
/// eigen_tcf.hpp, or register_eigen_pruned, which also prunes. Besides
///   SOLVER/size:N, the first two           growth, at 95 % outliers and sigma 0.1 m
///   register_tcf/budget/outliers:R/sigma:S/seeds:M   max_seeds = M
/// One seed an iteration. `median_ms` is the median over the seeds of a registration's CPU time, `recall` the share of
/// them that found the pose. For register_tcf STAGE_ms is the median time of a stage and `peak_mib` the memory needed
/// over that of the correspondences; its result for the first seed is checked against the scalar reference's before.
void register_registration_benchmarks();

}  // namespace consimd::bench
