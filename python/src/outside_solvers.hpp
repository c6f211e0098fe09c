// Solvers of others in studies under Python.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <nanobind/nanobind.h>

#include <consimd/studies/outside_solver.hpp>

namespace consimd::python {

/// Name, function of `_outside.py` or None, command, version. Without a function the command is that of a program.
using OutsideEntry = std::tuple<std::string, nanobind::object, std::string, std::string>;

/// The functions are borrowed: the entries must outlive the solvers. Starts the programs, each with that time limit in
/// seconds, to be killed at work once `stop` is true; call it with the interpreter's lock held.
[[nodiscard]] studies::OutsideSolvers outside_solvers(const std::vector<OutsideEntry>& entries, double time_limit,
                                                      const std::shared_ptr<const std::atomic<bool>>& stop);

}  // namespace consimd::python
