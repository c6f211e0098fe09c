#include <consimd/kernels/angle_consistency.hpp>

#include "dispatch.hpp"
#include "kernel_arguments.hpp"

namespace consimd {
namespace {

void check(const CorrespondenceView& view, std::span<const IndexPair> pairs, std::span<std::uint32_t> counts) {
  detail::require_size("counts", counts.size(), pairs.size());
  for (const IndexPair& pair : pairs) {
    detail::require_index(pair.first, view.size());
    detail::require_index(pair.second, view.size());
  }
}

}  // namespace

void angle_consistency_counts(const CorrespondenceView& view, std::span<const IndexPair> pairs, double bound,
                              std::span<std::uint32_t> counts) {
  check(view, pairs, counts);
  const float length = detail::working_length(view, bound, "bound");
  detail::active_table().angle_counts(detail::raw_view(view), pairs.data(), pairs.size(), length, counts.data());
}

void angle_consistency_bits(const CorrespondenceView& view, std::span<const IndexPair> pairs, double bound,
                            std::span<std::uint64_t> bits, std::span<std::uint32_t> counts) {
  check(view, pairs, counts);
  detail::require_size("bits", bits.size(), pairs.size() * view.words());
  const float length = detail::working_length(view, bound, "bound");
  detail::active_table().angle_bits(detail::raw_view(view), pairs.data(), pairs.size(), length, bits.data(),
                                    counts.data());
}

}  // namespace consimd
