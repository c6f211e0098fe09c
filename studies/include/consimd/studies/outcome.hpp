// What a solver, or a method made of several, returned for a problem of a study.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

struct Outcome {
  /// A solver's; "pose", "no_pose" or "rows" (a set without a pose) of stages; "crashed" or "timed_out" of an outside
  /// program.
  std::string status;
  bool has_pose = false;
  RigidTransform T_target_source = RigidTransform::Identity();  ///< of the scaled source
  double scale = 1.0;                                           ///< of the source
  std::vector<std::uint32_t> kept = {};  ///< rows left in the end: a pose's inliers, or what the last stage let through
  double seconds = 0.0;
  std::string failure = {};  ///< how an outside program failed, and on which problem; empty where none did
};

[[nodiscard]] Outcome outcome_of(Registration result);

}  // namespace studies
}  // namespace consimd
