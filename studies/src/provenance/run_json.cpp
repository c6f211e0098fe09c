#include "provenance/run_json.hpp"

#include <stdexcept>

#include <fmt/format.h>

#include <consimd/studies/build_info.hpp>

namespace consimd::studies {
namespace {

Json build_json() {
  const BuildInfo& build = build_info();
  return {{"version", build.version}, {"commit", build.commit}};
}

/// A value as an option takes it: lists without brackets and quotes, long ones cut.
std::string shown(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  constexpr std::size_t kLongest = 8;
  std::string text;
  for (std::size_t i = 0; i < value.size() && i < kLongest; ++i) {
    text += i == 0 ? "" : ",";
    text += shown(value[i]);
  }
  return value.size() > kLongest ? fmt::format("{},... ({} values)", text, value.size()) : text;
}

/// Keys of objects within objects are told one after the other.
std::string first_difference(const Json& there, const Json& here, const std::string& within = {}) {
  for (const auto& [name, value] : here.items()) {
    const std::string key = within + name;
    const Json other = there.is_object() ? there.value(name, Json()) : Json();
    if (other == value) continue;
    if (other.is_object() && value.is_object()) {
      std::string inside = first_difference(other, value, key + " ");
      if (inside.empty()) inside = fmt::format("it has another {}", key);  // with more than is here
      return inside;
    }
    if (other.is_array() && value.is_array() && shown(other) == shown(value)) {
      return fmt::format("it has another list of {} values", key);
    }
    return fmt::format("it has {} {}, not {}", key, shown(other), shown(value));
  }
  return {};
}

}  // namespace

Json environment_json(std::string_view isa, int threads) {
  const Machine machine = this_machine();
  const BuildInfo& build = build_info();
  Json json = build_json();
  json["compiler"] = build.compiler;
  json["flags"] = build.flags;
  json["build_type"] = build.build_type;
  json["machine"] = {{"cpu", machine.cpu}, {"system", machine.system}, {"hardware_threads", machine.hardware_threads}};
  json["isa"] = isa;
  json["threads"] = threads;
  return json;
}

Json outside_json(const OutsideSolvers& outside) {
  Json json = Json::object();
  for (const OutsideSolver& solver : outside) {
    json[solver.name] = {{"command", solver.command}, {"version", solver.version}, {"time limit", solver.time_limit}};
  }
  return json;
}

OutsideSolvers outside_of(const Json& json) {
  OutsideSolvers outside;
  try {
    for (const auto& [name, solver] : json.items()) {
      outside.push_back({.name = name,
                         .command = solver.at("command").get<std::string>(),
                         .version = solver.at("version").get<std::string>(),
                         .time_limit = solver.at("time limit").get<double>()});
    }
  } catch (const Json::exception& error) {
    throw std::invalid_argument(fmt::format("not the summary of a study: {}", error.what()));
  }
  return outside;
}

std::string summary_text(const Json& summary) {
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string difference(std::string_view summary, const Json& options) {
  const Json found = parse_json(summary);
  if (!found.is_object() || !found.contains("options")) throw std::invalid_argument("not the summary of a study");
  const std::string of_options = first_difference(found["options"], options);
  return of_options.empty() ? first_difference(found, build_json()) : of_options;
}

}  // namespace consimd::studies
