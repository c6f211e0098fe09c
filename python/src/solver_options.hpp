// The options that each solver has of its own, as Python's keyword arguments.
#pragma once

#include <cstdint>
#include <string_view>

#include <nanobind/nanobind.h>

#include <consimd/solvers/solver.hpp>

namespace consimd::python {

/// The named solver with its default options but for those in `given`. Throws nanobind::type_error on an option that it
/// lacks or a value of the wrong type, nanobind::value_error on a bad value, std::invalid_argument on an unknown
/// solver.
[[nodiscard]] SolverCall solver_with_options(std::string_view solver, std::uint64_t seed, nanobind::dict given);

/// Option names and default values of the named solver. Throws std::invalid_argument on an unknown one.
[[nodiscard]] nanobind::dict default_options(std::string_view solver);

}  // namespace consimd::python
