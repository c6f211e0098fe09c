// The options that each solver has of its own, as Python's keyword arguments.
#pragma once

#include <string_view>

#include <nanobind/nanobind.h>

#include <consimd/solvers/registry.hpp>

namespace consimd::python {

/// The solver of that name with the options in `given`. Throws nanobind::type_error on an option that it lacks or a
/// value of the wrong type, std::invalid_argument on a value out of range and on an unknown solver.
[[nodiscard]] SolverChoice solver_with_options(std::string_view solver, const nanobind::dict& given);

/// The options of a solver by name, each a tuple: default, unit, what is expected, meaning. Throws
/// std::invalid_argument on an unknown solver.
[[nodiscard]] nanobind::dict describe_options(std::string_view solver);

}  // namespace consimd::python
