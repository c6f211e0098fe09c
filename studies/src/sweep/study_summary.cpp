#include <consimd/studies/study_summary.hpp>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "provenance/run_json.hpp"

namespace consimd::studies {
namespace {

Json to_json(const SweepOptions& options) {
  Json json{{"points", options.points}, {"outliers", options.outlier_ratios}, {"sigma", options.sigmas},
            {"trials", options.trials}, {"solver", options.solvers},          {"filter", to_string(options.filter)},
            {"seed", options.seed}};
  if (!options.outside.empty()) json["outside"] = outside_json(options.outside);
  return json;
}

/// Adds what was run to an environment.
std::string with_study(Json summary, const TrialTable& table, bool complete) {
  summary["options"] = to_json(table.options());
  if (table.shard()) summary["shard"] = to_string(*table.shard());
  summary["noise_bound"] = "3 sigma";
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
void read_whole_number(const Json& options, const char* key, Number& number) {
  const Json& value = options.at(key);
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::numeric_limits<Number>::max()) {
    throw std::invalid_argument(fmt::format("not the summary of a study: bad {}", key));
  }
  number = value.get<Number>();
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
  return difference(summary, to_json(options));
}

SweepOptions options_of(std::string_view summary) {
  const Json json = parse(summary);
  SweepOptions options;
  try {
    const Json& there = json["options"];
    read_whole_number(there, "points", options.points);
    there.at("outliers").get_to(options.outlier_ratios);
    there.at("sigma").get_to(options.sigmas);
    read_whole_number(there, "trials", options.trials);
    there.at("solver").get_to(options.solvers);
    options.filter = filter_by_name(there.at("filter").get<std::string>());
    read_whole_number(there, "seed", options.seed);
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
