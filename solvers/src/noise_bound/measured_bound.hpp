// Bounds that the residuals around a pose tell.
#pragma once

#include <consimd/kernels/correspondences.hpp>

#include "noise_bound/bound_attempts.hpp"

namespace consimd::detail {

/// The largest bound that is tried, caller's unit: a share of the extent of the sources, 0 where all are one point.
[[nodiscard]] double largest_bound_of(const Correspondences& correspondences);

/// Whether two bounds differ by less than a measurement does.
[[nodiscard]] bool are_alike(double bound, double other);

/// Three times the scale of the residuals around the pose, from the bound that it was found with, and the pose that is
/// most likely with it.
[[nodiscard]] Attempt measured(const Correspondences& correspondences, const Attempt& attempt);

/// The measured bound. Where the pose is significant with that of the attempt and is not with what is measured, of what
/// lies between the first that will do.
[[nodiscard]] double measured_bound(const Correspondences& correspondences, CloseLooks& looks, const Attempt& attempt);

/// The pose of an attempt at another bound, held against random pairing alone.
[[nodiscard]] Attempt brought_to(const Correspondences& correspondences, const Attempt& attempt, double bound);

}  // namespace consimd::detail
