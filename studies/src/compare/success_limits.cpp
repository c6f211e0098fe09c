#include <consimd/studies/success_limits.hpp>

#include <stdexcept>

#include <fmt/format.h>

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
};

}  // namespace

std::string to_string(const PoseLimits& limits) {
  return fmt::format("{:g} deg, {:g} m", limits.rotation_deg, limits.translation);
}

std::span<const LimitPreset> limit_presets() noexcept { return kPresets; }

void require_known_preset(std::string_view preset) {
  std::string known;
  for (const LimitPreset& candidate : kPresets) {
    if (candidate.name == preset) return;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", candidate.name);
  }
  throw std::invalid_argument(fmt::format("unknown thresholds '{}'; known: {}", preset, known));
}

std::optional<PoseLimits> preset_limits(std::string_view preset, std::string_view dataset) {
  require_known_preset(preset);
  if (preset == "case") return std::nullopt;
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
