// When a registration counts as a success.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>

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

/// Named limits of the literature.
struct LimitPreset {
  std::string_view name;
  std::string_view description;
};

/// "case" (what each case states), "paper", "eth", "kitti", "kitti06", "3dmatch".
[[nodiscard]] std::span<const LimitPreset> limit_presets() noexcept;

/// The limits that a preset sets for a data set; none for "case". Throws std::invalid_argument on an unknown preset and
/// on a data set that the preset says nothing about.
[[nodiscard]] std::optional<PoseLimits> preset_limits(std::string_view preset, std::string_view dataset);

/// Throws std::invalid_argument that lists the known presets unless `preset` is one.
void require_known_preset(std::string_view preset);

}  // namespace studies
}  // namespace consimd
