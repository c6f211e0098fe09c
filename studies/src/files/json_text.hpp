// JSON that may come from anywhere.
#pragma once

#include <string_view>

#include <nlohmann/json.hpp>

namespace consimd::studies {

/// Keeps the order of its keys.
using Json = nlohmann::ordered_json;

/// The value of a JSON text. Throws std::invalid_argument that says what is wrong: no JSON, or nested so deep that
/// copying the value could exhaust the stack.
[[nodiscard]] Json parse_json(std::string_view text);

}  // namespace consimd::studies
