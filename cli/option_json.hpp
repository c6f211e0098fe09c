// Options of solvers as JSON.
#pragma once

#include <cmath>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include <consimd/solvers/registry.hpp>

namespace consimd::cli {

/// null for none; infinity, which JSON lacks, as "inf".
[[nodiscard]] inline nlohmann::ordered_json option_json(const OptionValue& value) {
  struct Json {
    nlohmann::ordered_json operator()(std::monostate /*none*/) const { return nullptr; }
    nlohmann::ordered_json operator()(bool truth) const { return truth; }
    nlohmann::ordered_json operator()(std::uint64_t number) const { return number; }
    nlohmann::ordered_json operator()(double number) const {
      return std::isfinite(number) ? nlohmann::ordered_json(number) : nlohmann::ordered_json(to_string(number));
    }
    nlohmann::ordered_json operator()(const std::string& name) const { return name; }
  };
  return std::visit(Json(), value);
}

[[nodiscard]] inline nlohmann::ordered_json options_json(std::span<const OptionSetting> settings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const OptionSetting& setting : settings) json[setting.name] = option_json(setting.value);
  return json;
}

}  // namespace consimd::cli
