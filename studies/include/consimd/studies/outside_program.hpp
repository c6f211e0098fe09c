// Any program as a solver of a study: docs/outside_solvers.md has the protocol.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/outside_solver.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Seconds that a program has for a problem, and to get ready, unless told otherwise.
inline constexpr double kDefaultTimeLimit = 60.0;

struct OutsideProgram {
  std::string name;
  std::string command;                    ///< as /bin/sh takes it
  bool binary = false;                    ///< problems as little-endian binary numbers, not as text
  double time_limit = kDefaultTimeLimit;  ///< seconds a problem, and to get ready; finite and > 0
  std::string version = {};               ///< empty: what the program tells
  /// Asked while the program works on a problem, from any thread; true kills it, and `solve` throws SolverStopped.
  std::function<bool()> stop_requested = {};
};

/// The program of "NAME=exec:COMMAND" or "NAME=exec-binary:COMMAND"; none if the text is of another form. Throws
/// std::invalid_argument if there is no command.
[[nodiscard]] std::optional<OutsideProgram> parse_outside_program(std::string_view text);

/// Starts the program, which tells its version, and makes a solver of it. In a study it runs once per thread; one that
/// crashed or was too slow is started again, and the trial counts as failed. The programs end with the last copy of the
/// solver. Throws std::runtime_error if the program does not start and say that it is ready, also later, from `solve`,
/// and on a reply that is against the protocol; std::invalid_argument on a bad time limit.
[[nodiscard]] OutsideSolver start_outside_program(const OutsideProgram& program);

}  // namespace studies
}  // namespace consimd
