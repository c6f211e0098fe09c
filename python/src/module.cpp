// consimd._core: the library as the Python modules beside it use it.
#include <nanobind/nanobind.h>

#include <consimd/version.hpp>

#include "bindings.hpp"
#include "interruptible_call.hpp"

NB_MODULE(_core, module) {
  using namespace consimd::python;
  bind_isa(module);
  bind_correspondences(module);
  bind_consensus_kernels(module);
  bind_fit_kernels(module);
  bind_consistency_matrix(module);
  bind_registration(module);
  bind_problems(module);
  bind_metrics(module);
  bind_features(module);
  bind_cloud_registration(module);
  bind_pictures(module);
  bind_sweep(module);
  bind_compare(module);
  module.attr("__version__") = CONSIMD_VERSION_STRING;
  nanobind::module_::import_("atexit").attr("register")(
      nanobind::cpp_function(&join_work_left_behind, nanobind::call_guard<nanobind::gil_scoped_release>()));
}
