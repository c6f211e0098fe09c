#include <consimd/studies/success_limits.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>

#include <fmt/format.h>

#include "text/words.hpp"

namespace consimd::studies {
namespace {

constexpr PoseLimits kEth{5.0, 0.5};
constexpr PoseLimits kKitti{5.0, 1.0};
constexpr PoseLimits kKitti06{5.0, 0.6};
constexpr PoseLimits k3dMatch{15.0, 0.3};

constexpr LimitPreset kPresets[] = {
    {"case", "the limits that each case states"},
    {"paper", "those of the TCF paper: ETH 5 deg, 0.5 m; KITTI 5 deg, 1 m"},
    {"eth", "5 deg, 0.5 m"},
    {"kitti", "5 deg, 1 m"},
    {"kitti06", "5 deg, 0.6 m, as most papers have it for KITTI"},
    {"3dmatch", "15 deg, 0.3 m"},
    {kDisplacementPreset, "RMSE of the overlap's points below 0.2 m by gt.info, 3DMatch's own; of its fragments"},
};

/// "5,0.6"; none if it is something else.
std::optional<PoseLimits> own_limits(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const auto number = [](std::string_view word) {
    const double value = text::number_in<double>(word).value_or(0.0);
    return std::isfinite(value) ? value : 0.0;
  };
  const PoseLimits limits{number(text.substr(0, comma)), number(text.substr(comma + 1))};
  return limits.rotation_deg > 0.0 && limits.translation > 0.0 ? std::optional(limits) : std::nullopt;
}

}  // namespace

std::string to_string(const PoseLimits& limits) {
  return fmt::format("{:g} deg, {:g} m", limits.rotation_deg, limits.translation);
}

double root_mean_square_displacement(const std::array<double, 36>& information, const RigidTransform& estimate,
                                     const RigidTransform& truth) {
  const RigidTransform error = truth.inverse() * estimate;
  const Eigen::Quaterniond turn(error.rotation());
  const double sign = turn.w() < 0.0 ? -1.0 : 1.0;
  const std::array<double, 6> x{error.translation().x(), error.translation().y(), error.translation().z(),
                                sign * turn.x(),         sign * turn.y(),         sign * turn.z()};
  double sum = 0.0;
  for (std::size_t r = 0; r < 6; ++r) {
    for (std::size_t c = 0; c < 6; ++c) sum += x[r] * information[6 * r + c] * x[c];
  }
  return std::sqrt(std::max(sum, 0.0) / information[0]);
}

std::span<const LimitPreset> limit_presets() noexcept { return kPresets; }

void require_known_preset(std::string_view preset) {
  if (own_limits(preset)) return;
  std::string known;
  for (const LimitPreset& candidate : kPresets) {
    if (candidate.name == preset) return;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", candidate.name);
  }
  throw std::invalid_argument(
      fmt::format("unknown thresholds '{}'; known: {}, or DEGREES,METRES above 0", preset, known));
}

std::optional<PoseLimits> preset_limits(std::string_view preset, std::string_view dataset) {
  require_known_preset(preset);
  if (preset == "case") return std::nullopt;
  if (const std::optional<PoseLimits> limits = own_limits(preset)) return limits;
  if (preset == kDisplacementPreset) {
    throw std::invalid_argument(
        fmt::format("thresholds: {} needs the gt.info of fragments in the layout 3dmatch", preset));
  }
  if (preset == "eth") return kEth;
  if (preset == "kitti") return kKitti;
  if (preset == "kitti06") return kKitti06;
  if (preset == "3dmatch") return k3dMatch;
  if (dataset == "ETH") return kEth;
  if (dataset == "KITTI") return kKitti;
  throw std::invalid_argument(fmt::format(
      "thresholds: the paper has none for data set '{}'; 'case' takes those that each case states", dataset));
}

}  // namespace consimd::studies
