#include <consimd/solvers/registration.hpp>

namespace consimd {

std::string_view to_string(Status status) noexcept {
  switch (status) {
    case Status::success:
      return "success";
    case Status::too_few_correspondences:
      return "too_few_correspondences";
    case Status::no_consensus:
      return "no_consensus";
    case Status::degenerate_geometry:
      return "degenerate_geometry";
    case Status::ambiguous:
      return "ambiguous";
    case Status::budget_exhausted:
      return "budget_exhausted";
  }
  return "unknown";
}

}  // namespace consimd
