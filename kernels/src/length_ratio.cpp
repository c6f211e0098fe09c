#include <consimd/kernels/length_ratio.hpp>

#include "dispatch.hpp"
#include "kernel_arguments.hpp"

namespace consimd {

void length_disagreement(const CorrespondenceView& view, std::span<const std::uint32_t> seeds, double bound,
                         double ratio_bound, std::span<float> costs) {
  detail::require_size("costs", costs.size(), seeds.size());
  for (const std::uint32_t seed : seeds) detail::require_index(seed, view.size());
  const detail::RatioBounds bounds{detail::working_length(view, bound, "bound"),
                                   detail::ratio_bound(ratio_bound, "ratio_bound")};
  detail::active_table().length_disagreement(detail::raw_view(view), seeds.data(), seeds.size(), bounds, costs.data());
}

void scale_intervals(const CorrespondenceView& view, std::uint32_t seed, double bound, std::span<float> lows,
                     std::span<float> highs) {
  detail::require_index(seed, view.size());
  detail::require_size("lows", lows.size(), view.padded_size());
  detail::require_size("highs", highs.size(), view.padded_size());
  const float length = detail::working_length(view, bound, "bound");
  detail::active_table().scale_intervals(detail::raw_view(view), seed, length, lows.data(), highs.data());
}

}  // namespace consimd
