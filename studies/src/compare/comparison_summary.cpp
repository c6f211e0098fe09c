#include "compare/comparison_summary.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/studies/method.hpp>
#include "files/digest.hpp"
#include "provenance/run_json.hpp"
#include "text/words.hpp"

namespace consimd::studies::detail {
namespace {

/// What the cases were read from, by their names.
Json digests_json(const CaseGroup& group) {
  Json digests = Json::object();
  for (const Case& one : group.cases) {
    if (!one.digest.empty()) digests[one.name] = one.digest;
  }
  return digests;
}

/// Hashes of the values of all options of the methods that are solvers.
Json solver_options_json(const Comparison& comparison) {
  Json digests = Json::object();
  for (const CaseGroup& group : comparison.groups()) {
    for (const std::string& method : group.methods) {
      if (outside_method(comparison.outside(), method)) continue;
      const std::string values = option_values(method);
      if (values.empty()) continue;
      Digest digest;
      digest.add(values);
      digests[method] = digest.text();
    }
  }
  return digests;
}

/// A group with all that the tables need of its cases.
Json whole_group_json(const CaseGroup& group) {
  Json json{
      {"name", group.name}, {"provenance", group.provenance}, {"methods", group.methods}, {"cases", Json::array()}};
  for (const Case& one : group.cases) {
    Json entry{{"name", one.name}, {"seed", one.seed}, {"digest", one.digest}};
    if (!std::isnan(one.distance)) entry["distance"] = one.distance;
    if (one.limits) entry["limits"] = {one.limits->rotation_deg, one.limits->translation};
    if (one.displacement) entry["displacement"] = one.displacement->root_mean_square;
    json["cases"].push_back(std::move(entry));
  }
  return json;
}

CaseGroup whole_group(const Json& json) {
  CaseGroup group{.name = json.at("name").get<std::string>(),
                  .provenance = json.at("provenance").get<std::string>(),
                  .methods = json.at("methods").get<std::vector<std::string>>()};
  for (const Json& entry : json.at("cases")) {
    Case one{.name = entry.at("name").get<std::string>(),
             .seed = entry.at("seed").get<std::uint64_t>(),
             .digest = entry.at("digest").get<std::string>(),
             .distance = entry.value("distance", std::numeric_limits<double>::quiet_NaN())};
    if (entry.contains("limits")) {
      one.limits = {entry["limits"].at(0).get<double>(), entry["limits"].at(1).get<double>()};
    }
    if (entry.contains("displacement")) {
      one.displacement = DisplacementLimit{.root_mean_square = entry["displacement"].get<double>()};
    }
    group.cases.push_back(std::move(one));
  }
  return group;
}

/// The object that `json` has as `key`, an empty one where it has none.
Json object_at(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_object() ? *found : Json::object();
}

std::string case_difference(const Json& there, const CaseGroup& group) {
  const Json here = digests_json(group);
  for (const auto& [name, digest] : here.items()) {
    const auto found = there.find(name);
    if (found == there.end()) return fmt::format("case {} of {} is new", name, group.name);
    if (*found != digest) return fmt::format("case {} of {} has changed", name, group.name);
  }
  for (const auto& [name, digest] : there.items()) {
    if (!here.contains(name)) return fmt::format("case {} of {} is gone", name, group.name);
  }
  return {};
}

/// The first case or method of `comparison` that is not what it was when the summary was written.
std::string data_difference(const Json& summary, const Comparison& comparison) {
  std::map<std::string, Json> digests;
  const auto data = summary.find("data");
  for (const Json& group : data != summary.end() ? *data : Json::array()) {
    if (group.is_object() && group.contains("group") && group["group"].is_string()) {
      digests[group["group"].get<std::string>()] = object_at(group, "digests");
    }
  }
  for (const CaseGroup& group : comparison.groups()) {
    const auto there = digests.find(group.name);
    const Json none = Json::object();
    if (std::string what = case_difference(there == digests.end() ? none : there->second, group); !what.empty()) {
      return what;
    }
  }
  const Json options = object_at(summary, "solver_options");
  const Json here = solver_options_json(comparison);
  for (const auto& [method, digest] : here.items()) {
    if (options.value(method, Json()) != digest) return fmt::format("{} had other options", method);
  }
  return {};
}

std::string shown(const std::optional<Shard>& shard) {
  return shard ? fmt::format("shard {}", to_string(*shard)) : "the whole comparison";
}

std::vector<std::string> parts(const Json& options, const char* key) {
  const std::string text = options.at(key).get<std::string>();
  std::vector<std::string_view> found = text::split(text, ',');
  if (found.back().empty()) found.pop_back();  // the one part of an empty text
  return {found.begin(), found.end()};
}

template <typename Number>
Number number_in(std::string_view text, std::string_view what) {
  if (const auto value = text::number_in<Number>(text)) return *value;
  throw std::invalid_argument(fmt::format("not the summary of a comparison: bad {}", what));
}

template <typename Number>
std::vector<Number> numbers(const Json& options, const char* key) {
  std::vector<Number> values;
  for (const std::string& text : parts(options, key)) values.push_back(number_in<Number>(text, key));
  return values;
}

/// A text, or several separated by commas.
std::string listed(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::vector<std::string> texts;
  for (const Json& one : value) texts.push_back(listed(one));
  return fmt::format("{}", fmt::join(texts, ", "));
}

Json cpus(const Json& machine) {
  if (!machine.is_array()) return machine.value("cpu", Json(""));
  Json all = Json::array();
  for (const Json& one : machine) all.push_back(one.value("cpu", Json("")));
  return all;
}

}  // namespace

Json options_json(const std::vector<OptionText>& options, const OutsideSolvers& outside) {
  Json json = Json::object();
  for (const auto& [name, value] : options) json[name] = value;
  if (!outside.empty()) json["outside"] = outside_json(outside);
  return json;
}

Json comparison_json(Json environment, Json options, const Comparison& comparison) {
  Json json = std::move(environment);
  json["options"] = std::move(options);
  if (comparison.shard()) json["shard"] = to_string(*comparison.shard());
  json["data"] = Json::array();
  for (const CaseGroup& group : comparison.groups()) {
    json["data"].push_back({{"group", group.name}, {"provenance", group.provenance}, {"cases", group.cases.size()}});
    if (Json digests = digests_json(group); !digests.empty()) json["data"].back()["digests"] = std::move(digests);
  }
  json["solver_options"] = solver_options_json(comparison);
  json["runs_total"] = comparison.size();
  json["runs_done"] = comparison.filled();
  json["complete"] = comparison.complete();
  if (comparison.shard()) {
    json["groups"] = Json::array();
    for (const CaseGroup& group : comparison.groups()) json["groups"].push_back(whole_group_json(group));
  }
  return json;
}

std::string comparison_difference(std::string_view text, const Json& options, const Comparison& comparison) {
  std::string other = difference(text, options);
  if (!other.empty()) return other;
  const std::optional<Shard> shard = comparison_shard(text);
  if (shard != comparison.shard()) return fmt::format("it is {}, not {}", shown(shard), shown(comparison.shard()));
  return data_difference(parse_json(text), comparison);
}

std::string environment_line(const Json& summary) {
  const Json& threads = summary.at("threads");
  return fmt::format("consimd {} ({}), {} on {} thread{}, {}, {}.", listed(summary.at("version")),
                     listed(summary.at("commit")), listed(summary.at("isa")), listed(threads),
                     threads == Json(1) ? "" : "s", listed(summary.at("compiler")),
                     listed(cpus(summary.at("machine"))));
}

std::optional<Shard> comparison_shard(std::string_view text) {
  const Json json = parse_json(text);
  if (!json.is_object() || !json.contains("options")) throw std::invalid_argument("not the summary of a comparison");
  if (!json.contains("shard")) return std::nullopt;
  if (!json["shard"].is_string()) throw std::invalid_argument("not the summary of a comparison: bad shard");
  return parse_shard(json["shard"].get<std::string>());
}

ShardedComparison sharded_comparison(std::string_view text) {
  constexpr std::uint32_t kMostRuns = 1'000'000;  // as the command takes them
  ShardedComparison found{.summary = parse_json(text), .groups = {}, .tables = {}};
  try {
    const Json& options = found.summary.at("options");
    for (const Json& group : found.summary.at("groups")) found.groups.push_back(whole_group(group));
    found.runs = number_in<std::uint32_t>(options.at("seeds").get<std::string>(), "seeds");
    if (found.runs == 0 || found.runs > kMostRuns)
      throw std::invalid_argument("not the summary of a comparison: bad seeds");
    found.tables = {.tables = parts(options, "table"),
                    .solvers = parts(options, "solver"),
                    .filtered = options.at("filter").get<std::string>() != "none",
                    .preset = options.at("thresholds").get<std::string>(),
                    .iterations = numbers<std::uint32_t>(options, "iterations"),
                    .scales = numbers<double>(options, "scales")};
    if (options.contains("outside")) found.tables.outside = outside_of(options.at("outside"));
    // What the summary of a merged one tells.
    for (const char* key : {"version", "commit", "compiler", "machine", "isa", "threads"}) {
      static_cast<void>(found.summary.at(key));
    }
  } catch (const Json::exception& error) {
    throw std::invalid_argument(fmt::format("not the summary of a comparison's shard: {}", error.what()));
  }
  validate(found.tables);
  return found;
}

}  // namespace consimd::studies::detail
