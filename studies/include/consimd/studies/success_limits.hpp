// When a registration counts as a success.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Largest errors of a success.
struct PoseLimits {
  double rotation_deg = 0.0;
  double translation = 0.0;  ///< caller's unit, metres in the presets

  bool operator==(const PoseLimits&) const = default;
};

/// "5 deg, 0.5 m"
[[nodiscard]] std::string to_string(const PoseLimits& limits);

/// The largest root mean square displacement, at a wrong pose, of the points that two fragments share: the measure of
/// Choi, Zhou, Koltun (CVPR 2015), of 3DMatch's own evaluation.
struct DisplacementLimit {
  /// 6 x 6, row by row, of translation and vector part of the unit quaternion; its first entry counts the points.
  std::array<double, 36> information{};
  double root_mean_square = 0.0;  ///< caller's unit

  bool operator==(const DisplacementLimit&) const = default;
};

/// That of `estimate`, by the information matrix. Caller's unit.
[[nodiscard]] double root_mean_square_displacement(const std::array<double, 36>& information,
                                                   const RigidTransform& estimate, const RigidTransform& truth);

/// The preset that is a limit of displacements, metres.
inline constexpr std::string_view kDisplacementPreset = "3dmatch-rmse";
inline constexpr double kDisplacementLimit = 0.2;

/// Named limits of the literature.
struct LimitPreset {
  std::string_view name;
  std::string_view description;
};

/// "case" (what each case states), "paper", "eth", "kitti", "kitti06", "3dmatch", "3dmatch-rmse".
[[nodiscard]] std::span<const LimitPreset> limit_presets() noexcept;

/// The limits that a preset sets for a data set; none for "case". Two numbers with a comma, degrees and metres,
/// "5,0.6", are limits of their own. Throws std::invalid_argument on an unknown preset, on a data set that the preset
/// says nothing about, and on "3dmatch-rmse", which sets no such limits.
[[nodiscard]] std::optional<PoseLimits> preset_limits(std::string_view preset, std::string_view dataset);

/// Throws std::invalid_argument that lists the known presets unless `preset` is one, or two numbers above 0.
void require_known_preset(std::string_view preset);

}  // namespace studies
}  // namespace consimd
