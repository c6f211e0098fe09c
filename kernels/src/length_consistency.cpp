#include <consimd/kernels/length_consistency.hpp>

#include "dispatch.hpp"
#include "kernel_arguments.hpp"

namespace consimd {
namespace {

void check(const CorrespondenceView& view, std::span<const std::uint32_t> seeds, std::span<std::uint32_t> counts) {
  detail::require_size("counts", counts.size(), seeds.size());
  for (const std::uint32_t seed : seeds) detail::require_index(seed, view.size());
}

}  // namespace

void length_consistency_counts(const CorrespondenceView& view, std::span<const std::uint32_t> seeds, double bound,
                               std::span<std::uint32_t> counts) {
  check(view, seeds, counts);
  const float length = detail::working_length(view, bound, "bound");
  detail::active_table().length_counts(detail::raw_view(view), seeds.data(), seeds.size(), length, counts.data());
}

void length_consistency_bits(const CorrespondenceView& view, std::span<const std::uint32_t> seeds, double bound,
                             std::span<std::uint64_t> bits, std::span<std::uint32_t> counts) {
  check(view, seeds, counts);
  detail::require_size("bits", bits.size(), seeds.size() * view.words());
  const float length = detail::working_length(view, bound, "bound");
  detail::active_table().length_bits(detail::raw_view(view), seeds.data(), seeds.size(), length, bits.data(),
                                     counts.data());
}

}  // namespace consimd
