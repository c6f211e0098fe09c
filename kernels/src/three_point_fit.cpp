#include <consimd/kernels/three_point_fit.hpp>

#include "dispatch.hpp"
#include "kernel_arguments.hpp"

namespace consimd {

void three_point_fits(const CorrespondenceView& view, std::span<const IndexTriple> triples,
                      std::span<WorkingPose> poses) {
  detail::require_size("poses", poses.size(), triples.size());
  for (const IndexTriple& triple : triples) {
    detail::require_index(triple.first, view.size());
    detail::require_index(triple.second, view.size());
    detail::require_index(triple.third, view.size());
  }
  detail::active_table().three_point_fits(detail::raw_view(view), triples.data(), triples.size(), poses.data());
}

}  // namespace consimd
