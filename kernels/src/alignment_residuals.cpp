#include <consimd/kernels/alignment_residuals.hpp>

#include "dispatch.hpp"
#include "kernel_arguments.hpp"

namespace consimd {

void alignment_counts(const CorrespondenceView& view, std::span<const WorkingPose> poses, double bound,
                      std::span<std::uint32_t> counts) {
  detail::require_size("counts", counts.size(), poses.size());
  const float length = detail::working_length(view, bound, "bound");
  detail::active_table().alignment_counts(detail::raw_view(view), poses.data(), poses.size(), length, counts.data());
}

void alignment_scores(const CorrespondenceView& view, std::span<const WorkingPose> poses, double bound,
                      std::span<PoseSupport> support) {
  detail::require_size("support", support.size(), poses.size());
  const float length = detail::working_length(view, bound, "bound");
  detail::active_table().alignment_scores(detail::raw_view(view), poses.data(), poses.size(), length, support.data());
}

void alignment_bits(const CorrespondenceView& view, std::span<const WorkingPose> poses, double bound,
                    std::span<std::uint64_t> bits, std::span<std::uint32_t> counts) {
  detail::require_size("counts", counts.size(), poses.size());
  detail::require_size("bits", bits.size(), poses.size() * view.words());
  const float length = detail::working_length(view, bound, "bound");
  detail::active_table().alignment_bits(detail::raw_view(view), poses.data(), poses.size(), length, bits.data(),
                                        counts.data());
}

void alignment_residuals(const CorrespondenceView& view, const WorkingPose& pose, std::span<float> squared) {
  detail::require_size("squared", squared.size(), view.words() * kBlock);
  detail::active_table().alignment_residuals(detail::raw_view(view), pose, squared.data());
}

void mismatched_counts(const CorrespondenceView& view, const WorkingPose& pose, double bound,
                       std::span<const std::uint32_t> shifts, std::span<std::uint32_t> counts) {
  detail::require_size("counts", counts.size(), shifts.size());
  const float length = detail::working_length(view, bound, "bound");
  for (std::size_t s = 0; s < shifts.size(); ++s) {
    counts[s] = 0;
    if (mismatched_pairs(view, shifts[s]) == 0) continue;
    // Shifting by whole blocks keeps the targets aligned; the lanes past the last correspondence are NaN, as
    // everywhere.
    detail::RawView shifted = detail::raw_view(view);
    const std::size_t lanes = kBlock * shifts[s];
    for (const float*& target : shifted.target) target += lanes;
    shifted.size -= lanes;
    shifted.padded -= lanes;
    detail::active_table().alignment_counts(shifted, &pose, 1, length, &counts[s]);
  }
}

std::size_t mismatched_pairs(const CorrespondenceView& view, std::uint32_t shift) noexcept {
  const std::size_t lanes = kBlock * shift;
  return shift > 0 && lanes < view.size() ? view.size() - lanes : 0;
}

}  // namespace consimd
