// Registers benchmarks of whole registrations: TCF with its default options, single thread.
#pragma once

namespace consimd::bench {

/// register_tcf/noise/outliers:R/sigma:S on cells of the noise study, and, where the environment variable
/// CONSIMD_TEST_DATA names a folder with correspondences/CASE/{correspondences.txt,pose.txt,case.json},
/// register_tcf/pair/CASE. One seed an iteration; `median_ms` is the median over the seeds of a registration's CPU time
/// and `recall` the share of them that found the pose. The result for the first seed is checked against the scalar
/// reference's before.
void register_registration_benchmarks();

}  // namespace consimd::bench
