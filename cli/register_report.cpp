#include "register_report.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "study/statistics.hpp"

namespace consimd::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json run_json(const RegisterReport& report, std::size_t index) {
  const Registration& run = report.runs[index];
  Json pose = Json::array();
  for (int row = 0; row < 4; ++row) {
    const Eigen::Vector4d values = run.T_target_source.matrix().row(row);
    pose.push_back(std::vector<double>(values.begin(), values.end()));
  }
  Json stages = Json::array();
  for (const StageReport& stage : run.stages) {
    stages.push_back({{"name", stage.name},
                      {"input", stage.input},
                      {"output", stage.output},
                      {"iterations", stage.iterations},
                      {"seconds", stage.seconds}});
  }
  Json json = {{"seed", run.seed},        {"status", to_string(run.status)},
               {"T_target_source", pose}, {"inlier_count", run.inliers.size()},
               {"inliers", run.inliers},  {"seconds", run.seconds},
               {"stages", stages}};
  if (!report.errors.empty()) {
    json["rotation_error_deg"] = report.errors[index].rotation_deg;
    json["translation_error"] = report.errors[index].translation;
  }
  return json;
}

std::string run_text(const RegisterReport& report) {
  const Registration& run = report.runs.front();
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "status        {} (seed {})\n", to_string(run.status), run.seed);
  fmt::format_to(out, "inliers       {} within {} of the pose\n", run.inliers.size(), report.noise_bound);
  fmt::format_to(out, "time          {:.3f} ms\n", 1e3 * run.seconds);
  for (const PoseErrors& error : report.errors) {
    fmt::format_to(out, "errors        rotation {:.4g} deg, translation {:.4g}\n", error.rotation_deg,
                   error.translation);
  }
  if (run.has_pose()) {
    fmt::format_to(out, "T_target_source\n");
    for (int row = 0; row < 4; ++row) {
      const Eigen::Vector4d v = run.T_target_source.matrix().row(row);
      fmt::format_to(out, "  {:24.17g} {:24.17g} {:24.17g} {:24.17g}\n", v[0], v[1], v[2], v[3]);
    }
  }
  if (!run.stages.empty())
    fmt::format_to(out, "{:<24}{:>10}{:>10}{:>12}{:>12}\n", "stage", "input", "output", "iterations", "ms");
  for (const StageReport& stage : run.stages) {
    fmt::format_to(out, "{:<24}{:>10}{:>10}{:>12}{:>12.3f}\n", stage.name, stage.input, stage.output, stage.iterations,
                   1e3 * stage.seconds);
  }
  return fmt::to_string(text);
}

/// The median of a number per run.
template <typename Runs, typename Number>
double median_of(const Runs& runs, Number number) {
  std::vector<double> values;
  std::transform(runs.begin(), runs.end(), std::back_inserter(values), number);
  return study::median(std::move(values));
}

std::string summary_text(const RegisterReport& report) {
  const std::vector<Registration>& runs = report.runs;
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  const auto found = std::count_if(runs.begin(), runs.end(), [](const Registration& run) { return run.has_pose(); });
  fmt::format_to(out, "runs          {} (seeds {} to {}), {} with a pose\n", runs.size(), runs.front().seed,
                 runs.back().seed, found);
  for (const Registration& run : runs) {
    if (!run.has_pose()) fmt::format_to(out, "no pose       seed {}: {}\n", run.seed, to_string(run.status));
  }
  fmt::format_to(out, "median        over all runs\n");
  fmt::format_to(out, "  inliers     {:g} within {} of the pose\n",
                 median_of(runs, [](const Registration& run) { return static_cast<double>(run.inliers.size()); }),
                 report.noise_bound);
  fmt::format_to(out, "  time        {:.3f} ms\n",
                 median_of(runs, [](const Registration& run) { return 1e3 * run.seconds; }));
  if (!report.errors.empty()) {
    fmt::format_to(out, "  errors      rotation {:.4g} deg, translation {:.4g}\n",
                   median_of(report.errors, [](const PoseErrors& error) { return error.rotation_deg; }),
                   median_of(report.errors, [](const PoseErrors& error) { return error.translation; }));
  }
  return fmt::to_string(text);
}

}  // namespace

std::string to_json(const RegisterReport& report) {
  const Json head = {{"file", report.file},     {"correspondences", report.correspondences},
                     {"isa", report.isa},       {"threads", report.threads},
                     {"solver", report.solver}, {"noise_bound", report.noise_bound}};
  std::string text = dump(head);
  text.pop_back();  // the closing brace: runs follow, each on a line of its own
  text += ",\n\"runs\":[";
  for (std::size_t i = 0; i < report.runs.size(); ++i) text += (i == 0 ? "\n" : ",\n") + dump(run_json(report, i));
  return text + "\n]}\n";
}

std::string to_text(const RegisterReport& report) {
  return fmt::format(
             "file          {}, {} correspondences (lengths below are in its unit)\n"
             "solver        {}, noise bound {}, {} on {} thread{}\n",
             report.file, report.correspondences, report.solver, report.noise_bound, report.isa, report.threads,
             report.threads == 1 ? "" : "s") +
         (report.runs.size() == 1 ? run_text(report) : summary_text(report));
}

}  // namespace consimd::cli
