// Results of the library as dictionaries, from which Python makes its classes.
#pragma once

#include <nanobind/nanobind.h>

#include <consimd/solvers/registration.hpp>

namespace consimd::python {

/// The fields of consimd.Registration but for those that its caller knows.
[[nodiscard]] nanobind::dict registration_fields(const Registration& result);

}  // namespace consimd::python
