#include "pipeline/voxel_choice.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include <consimd/features/cloud_matching.hpp>
#include <consimd/features/voxel_grid.hpp>
#include <consimd/kernels/elementary_functions.hpp>

#include "grid/box.hpp"

namespace consimd::features {
namespace {

// Voxels that are plenty for the front end.
constexpr double kVoxels = 12000.0;

// Rounded to two decimal digits.
double with_two_digits(double length) {
  const double digit = std::clamp(std::floor(elementary::log10(length)) - 1.0, -300.0, 300.0);
  double power = 1.0;
  for (double k = 0.0; k < std::abs(digit); ++k) power *= 10.0;
  const double rounded = digit < 0.0 ? std::round(length * power) / power : std::round(length / power) * power;
  return rounded > 0.0 ? rounded : length;
}

}  // namespace

double detail::voxel_for(const Cloud& cloud, double wanted) {
  const double length = extent(cloud);
  if (!(length > 0.0)) return 1.0;
  // The number of voxels falls about with the square of their side, of surfaces, so that a few steps suffice as a rule.
  constexpr int kSteps = 16;
  constexpr double kSmallestShare = 0x1p-18;
  double low = kSmallestShare * length;
  double high = length;
  double voxel = length / 256.0;
  for (int step = 0; step < kSteps; ++step) {
    const std::size_t count = occupied_voxels(cloud, voxel);
    const double ratio = static_cast<double>(count) / wanted;
    if (std::abs(ratio - 1.0) < 0.05) break;
    (ratio > 1.0 ? low : high) = voxel;
    // Where nearly every point has a voxel of its own, their number says little about the side that is wanted.
    const bool alone = static_cast<double>(count) > 0.95 * static_cast<double>(cloud.size());
    voxel *= alone ? 2.0 : std::sqrt(ratio);
    if (!(voxel > low && voxel < high)) voxel = std::sqrt(low * high);
  }
  return with_two_digits(voxel);
}

double detail::voxel_across_rings(const Cloud& cloud, double points_a_voxel) {
  return voxel_for(cloud, std::clamp(static_cast<double>(cloud.size()) / points_a_voxel, 1.0, kVoxels));
}

double choose_voxel(const Cloud& cloud) {
  if (cloud.empty()) throw std::invalid_argument("the cloud is empty: no voxel suits it");
  return detail::voxel_for(cloud, std::min(kVoxels, 0.75 * static_cast<double>(cloud.size())));
}

}  // namespace consimd::features
