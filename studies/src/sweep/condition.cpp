#include <consimd/studies/condition.hpp>

#include <stdexcept>

#include <fmt/format.h>

#include <consimd/studies/value_list.hpp>

namespace consimd::studies {
namespace {

constexpr std::string_view kEstimated = "estimated";

}  // namespace

std::string_view to_string(ScaleKnowledge scale) noexcept {
  return scale == ScaleKnowledge::known ? "known" : "unknown";
}

ScaleKnowledge scale_knowledge_by_name(std::string_view name) {
  for (const ScaleKnowledge scale : {ScaleKnowledge::known, ScaleKnowledge::unknown}) {
    if (name == to_string(scale)) return scale;
  }
  throw std::invalid_argument(fmt::format("scale '{}': expected one of: known, unknown", name));
}

std::string to_string(const BoundFactor& factor) {
  return factor ? fmt::format("{}", *factor) : std::string(kEstimated);
}

BoundFactor parse_bound_factor(std::string_view text) {
  if (text == kEstimated) return std::nullopt;
  double factor = 0.0;
  try {
    factor = parse_number(text);
  } catch (const std::invalid_argument&) {
    factor = 0.0;  // no better than this one: the message below says more
  }
  if (factor > 0.0) return factor;
  throw std::invalid_argument(fmt::format("bound_factor: expected a number > 0 or {}, got '{}'", kEstimated, text));
}

}  // namespace consimd::studies
