// The parts of the module consimd._core.
#pragma once

#include <memory>

#include <nanobind/nanobind.h>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::python {

/// What Python holds of a `Correspondences`. Shared, so that work which outlives its caller keeps it.
struct SharedCorrespondences {
  std::shared_ptr<const Correspondences> rows;
};

void bind_isa(nanobind::module_& module);
void bind_correspondences(nanobind::module_& module);
void bind_consensus_kernels(nanobind::module_& module);
void bind_fit_kernels(nanobind::module_& module);
void bind_consistency_matrix(nanobind::module_& module);
void bind_registration(nanobind::module_& module);
void bind_problems(nanobind::module_& module);
void bind_metrics(nanobind::module_& module);
void bind_features(nanobind::module_& module);
void bind_cloud_registration(nanobind::module_& module);
void bind_pictures(nanobind::module_& module);
void bind_sweep(nanobind::module_& module);
void bind_compare(nanobind::module_& module);

}  // namespace consimd::python
