// What a study varies beside outlier ratio and noise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Whether solvers are told the scale of the source. Where they are not, it is from 0.5 to 2, and they must find it.
enum class ScaleKnowledge : std::uint8_t { known, unknown };

/// "known", "unknown".
[[nodiscard]] std::string_view to_string(ScaleKnowledge scale) noexcept;

/// Inverse of `to_string`. Throws std::invalid_argument on an unknown name, listing the known ones.
[[nodiscard]] ScaleKnowledge scale_knowledge_by_name(std::string_view name);

/// The noise bound that solvers are given, over the study's 3 sigma; none: they estimate it from the correspondences.
using BoundFactor = std::optional<double>;

/// As tables have it: "1", "0.5", "estimated".
[[nodiscard]] std::string to_string(const BoundFactor& factor);

/// Inverse of `to_string`. Throws std::invalid_argument unless `text` is "estimated" or a finite number > 0.
[[nodiscard]] BoundFactor parse_bound_factor(std::string_view text);

/// The defaults are the paper's study.
struct Condition {
  std::string family = "gaussian";  ///< of problems, see consimd/synth/problem_families.hpp
  ScaleKnowledge scale = ScaleKnowledge::known;
  std::size_t points = 3000;  ///< correspondences of a problem
  BoundFactor bound_factor = 1.0;

  bool operator==(const Condition&) const = default;
};

}  // namespace studies
}  // namespace consimd
