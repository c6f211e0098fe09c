#include <consimd/kernels/rigid_moments.hpp>

#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>

#include "dispatch.hpp"
#include "kernel_arguments.hpp"

namespace consimd {
namespace {

detail::RawWeight raw_weight(const CorrespondenceView& view, const RobustWeight& weight) {
  if (!std::isfinite(weight.odds) || weight.odds < 0.0) {
    throw std::invalid_argument("odds is " + std::to_string(weight.odds) + ", expected a finite number of at least 0");
  }
  if (!std::has_single_bit(weight.exponent) || weight.exponent < 2 || weight.exponent > 64) {
    throw std::invalid_argument("exponent is " + std::to_string(weight.exponent) +
                                ", expected a power of two from 2 to 64");
  }
  const float scale = detail::working_length(view, weight.scale, "scale");
  const float cutoff = detail::working_length(view, weight.cutoff, "cutoff");
  detail::RawWeight raw{weight.function, 0.0f, cutoff * cutoff, static_cast<float>(weight.odds), 0};
  switch (weight.function) {
    case WeightFunction::truncated:
      break;
    case WeightFunction::cauchy:
      raw.inverse_squared_scale = 1.0f / (scale * scale);
      break;
    case WeightFunction::student_uniform:
      raw.inverse_squared_scale = 1.0f / (2.0f * static_cast<float>(weight.exponent) * scale * scale);
      raw.squarings = static_cast<std::uint32_t>(std::countr_zero(weight.exponent));
      // Without outliers 1 / y is left; said so, as 0 times a power that overflows would not be.
      if (raw.odds == 0.0f) raw.function = WeightFunction::cauchy;
      break;
  }
  return raw;
}

}  // namespace

RigidMoments weighted_moments(const CorrespondenceView& view, std::span<const float> weights) {
  detail::require_size("weights", weights.size(), view.padded_size());
  detail::require_aligned("weights", weights.data());
  RigidMoments moments;
  detail::active_table().weighted_moments(detail::raw_view(view), weights.data(), &moments);
  return moments;
}

RigidMoments subset_moments(const CorrespondenceView& view, std::span<const std::uint64_t> bits) {
  detail::require_size("bits", bits.size(), view.words());
  RigidMoments moments;
  detail::active_table().subset_moments(detail::raw_view(view), bits.data(), &moments);
  return moments;
}

RigidMoments robust_moments(const CorrespondenceView& view, const WorkingPose& pose, const RobustWeight& weight) {
  RigidMoments moments;
  detail::active_table().robust_moments(detail::raw_view(view), pose, raw_weight(view, weight), &moments);
  return moments;
}

}  // namespace consimd
