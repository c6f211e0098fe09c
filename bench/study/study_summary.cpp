#include "study/study_summary.hpp"

#include <initializer_list>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "study/build_info.hpp"

namespace consimd::study {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const SweepOptions& options) {
  return {{"points", options.points}, {"outliers", options.outlier_ratios}, {"sigma", options.sigmas},
          {"trials", options.trials}, {"solver", options.solvers},          {"seed", options.seed}};
}

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

}  // namespace

std::string summary_json(const SweepOptions& options, const RunFacts& facts) {
  const Machine machine = this_machine();
  const BuildInfo& build = build_info();
  Json summary = build_json();
  summary["compiler"] = build.compiler;
  summary["flags"] = build.flags;
  summary["build_type"] = build.build_type;
  summary["machine"] = {
      {"cpu", machine.cpu}, {"system", machine.system}, {"hardware_threads", machine.hardware_threads}};
  summary["isa"] = facts.isa;
  summary["threads"] = facts.threads;
  summary["options"] = to_json(options);
  summary["noise_bound"] = "3 sigma";
  summary["recall_interval"] = "Wilson, 95 %";
  summary["trials_total"] = options.cells() * options.trials;
  summary["trials_done"] = facts.trials_done;
  summary["complete"] = facts.complete;
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string difference(std::string_view summary, const SweepOptions& options) {
  const Json found = Json::parse(summary, nullptr, false);
  if (!found.is_object() || !found.contains("options")) throw std::invalid_argument("not the summary of a noise study");
  const auto first_difference = [](const Json& there, const Json& here) -> std::string {
    for (const auto& [key, value] : here.items()) {
      const Json other = there.is_object() ? there.value(key, Json()) : Json();
      if (other == value) continue;
      if (other.is_array() && value.is_array() && shown(other) == shown(value)) {
        return fmt::format("it has another list of {} values", key);
      }
      return fmt::format("it has {} {}, not {}", key, shown(other), shown(value));
    }
    return {};
  };
  const std::string of_options = first_difference(found["options"], to_json(options));
  return of_options.empty() ? first_difference(found, build_json()) : of_options;
}

}  // namespace consimd::study
