#include <consimd/studies/study_summary.hpp>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "provenance/run_json.hpp"

namespace consimd::studies {
namespace {

// Keys of what goes beyond the paper's study. Summaries of the paper's do not have them.
constexpr const char* kFamily = "family";
constexpr const char* kScale = "scale";
constexpr const char* kBoundFactor = "bound factor";
constexpr const char* kNoPose = "no pose";

/// Names of values.
template <typename Value>
Json names(const std::vector<Value>& values) {
  Json texts = Json::array();
  for (const Value& value : values) texts.push_back(to_string(value));
  return texts;
}

/// Inverse of it.
template <typename Parse>
auto parsed(const Json& texts, const Parse& parse) {
  std::vector<decltype(parse(std::string_view()))> values;
  for (const std::string& text : texts.get<std::vector<std::string>>()) values.push_back(parse(text));
  return values;
}

void add_conditions(Json& json, const SweepOptions& options) {
  json[kFamily] = options.families;
  json[kScale] = names(options.scales);
  json[kBoundFactor] = names(options.bound_factors);
  json[kNoPose] = options.no_pose;
}

Json to_json(const SweepOptions& options) {
  Json json{{"points", options.points}, {"outliers", options.outlier_ratios}, {"sigma", options.sigmas},
            {"trials", options.trials}, {"solver", options.solvers},          {"filter", to_string(options.filter)},
            {"seed", options.seed}};
  if (options.points.size() == 1) json["points"] = options.points.front();
  if (options.beyond_paper()) add_conditions(json, options);
  if (!options.outside.empty()) json["outside"] = outside_json(options.outside);
  return json;
}

/// Adds what was run to an environment.
std::string with_study(Json summary, const TrialTable& table, bool complete) {
  summary["options"] = to_json(table.options());
  if (table.shard()) summary["shard"] = to_string(*table.shard());
  summary["noise_bound"] = table.wide() ? "3 sigma times the bound factor, or estimated" : "3 sigma";
  if (table.wide()) {
    summary["success"] =
        "RMSE of the true inliers below 3 sigma; without Gaussian noise, mean square less than 6 "
        "sigma^2 above the oracle's";
  }
  summary["recall_interval"] = "Wilson, 95 %";
  summary["trials_total"] = table.size();
  summary["trials_done"] = table.filled();
  summary["complete"] = complete;
  return summary_text(summary);
}

Json parse(std::string_view summary) {
  Json json = parse_json(summary);
  if (!json.is_object() || !json.contains("options")) throw std::invalid_argument("not the summary of a study");
  return json;
}

/// A whole number that a 32-bit or 64-bit option can hold: JSON would convert any other without a word.
template <typename Number>
void read_whole_number(const Json& value, const char* key, Number& number) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::numeric_limits<Number>::max()) {
    throw std::invalid_argument(fmt::format("not the summary of a study: bad {}", key));
  }
  number = value.get<Number>();
}

/// One number, or several.
std::vector<std::size_t> read_points(const Json& options) {
  const Json& value = options.at("points");
  std::vector<std::size_t> points;
  for (const Json& number : value.is_array() ? value : Json::array({value})) {
    read_whole_number(number, "points", points.emplace_back());
  }
  return points;
}

std::string shown(const std::optional<Shard>& shard) {
  return shard ? fmt::format("shard {}", to_string(*shard)) : "the whole study";
}

}  // namespace

std::string summary_json(const TrialTable& table, const RunFacts& facts) {
  return with_study(environment_json(facts.isa, facts.threads), table, facts.complete);
}

std::string merged_summary_json(const TrialTable& table, std::span<const std::string> summaries) {
  Json merged = environment_json({}, 0);
  for (auto& [key, value] : merged.items()) {
    Json values = Json::array();
    for (const std::string& summary : summaries) {
      Json of_shard = parse(summary).value(key, Json());
      if (std::ranges::find(values, of_shard) == values.end()) values.push_back(std::move(of_shard));
    }
    value = values.size() == 1 ? values[0] : values;
  }
  return with_study(std::move(merged), table, table.complete());
}

std::string unfinished_summary(std::string_view summary) {
  Json json = parse(summary);
  json["complete"] = false;
  return summary_text(json);
}

std::string difference(std::string_view summary, const TrialTable& table) {
  std::string other = difference_but_shard(summary, table.options());
  if (!other.empty()) return other;
  const std::optional<Shard> shard = shard_of(summary);
  return shard == table.shard() ? "" : fmt::format("it is {}, not {}", shown(shard), shown(table.shard()));
}

std::string difference_but_shard(std::string_view summary, const SweepOptions& options) {
  // Both sides say all: a study that lacks a key is the paper's in it.
  Json there = parse(summary);
  Json paper = Json::object();
  add_conditions(paper, SweepOptions());
  if (there["options"].is_object()) {
    paper.update(there["options"]);
    there["options"] = paper;
  }
  Json here = to_json(options);
  add_conditions(here, options);
  return difference(summary_text(there), here);
}

SweepOptions options_of(std::string_view summary) {
  const Json json = parse(summary);
  SweepOptions options;
  try {
    const Json& there = json["options"];
    options.points = read_points(there);
    there.at("outliers").get_to(options.outlier_ratios);
    there.at("sigma").get_to(options.sigmas);
    read_whole_number(there.at("trials"), "trials", options.trials);
    there.at("solver").get_to(options.solvers);
    options.filter = filter_by_name(there.at("filter").get<std::string>());
    read_whole_number(there.at("seed"), "seed", options.seed);
    if (there.contains(kFamily)) {
      there.at(kFamily).get_to(options.families);
      options.scales = parsed(there.at(kScale), scale_knowledge_by_name);
      options.bound_factors = parsed(there.at(kBoundFactor), parse_bound_factor);
      there.at(kNoPose).get_to(options.no_pose);
    }
    if (there.contains("outside")) options.outside = outside_of(there.at("outside"));
  } catch (const Json::exception& error) {
    throw std::invalid_argument(fmt::format("not the summary of a study: {}", error.what()));
  }
  return options;
}

std::optional<Shard> shard_of(std::string_view summary) {
  const Json json = parse(summary);
  if (!json.contains("shard")) return std::nullopt;
  if (!json["shard"].is_string()) throw std::invalid_argument("not the summary of a study: bad shard");
  return parse_shard(json["shard"].get<std::string>());
}

}  // namespace consimd::studies
