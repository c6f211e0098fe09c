#include "register_report.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include <consimd/studies/statistics.hpp>

#include "option_json.hpp"

namespace consimd::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

template <typename Matrix>
Json rows_of(const Matrix& matrix) {
  Json rows = Json::array();
  for (const auto& row : matrix.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

Json run_json(const RegisterReport& report, std::size_t index) {
  const Registration& run = report.runs[index];
  Json stages = Json::array();
  for (const StageReport& stage : run.stages) {
    stages.push_back({{"name", stage.name},
                      {"input", stage.input},
                      {"output", stage.output},
                      {"iterations", stage.iterations},
                      {"seconds", stage.seconds}});
  }
  Json json = {{"seed", run.seed},
               {"status", to_string(run.status)},
               {"noise_bound", run.noise_bound},
               {"log10_false_poses", run.log10_false_poses},
               {"T_target_source", rows_of(run.T_target_source.matrix())},
               {"covariance", rows_of(run.covariance)},
               {"inlier_count", run.inliers.size()},
               {"inliers", run.inliers},
               {"seconds", run.seconds},
               {"stages", stages}};
  if (report.estimate_scale) {
    json["scale"] = run.scale;
    json["scale_deviation"] = run.scale_deviation;
  }
  if (run.runner_up) {
    json["runner_up"] = {{"support", run.runner_up->support},
                         {"log10_false_poses", run.runner_up->log10_false_poses},
                         {"T_target_source", rows_of(run.runner_up->T_target_source.matrix())}};
    if (report.estimate_scale) json["runner_up"]["scale"] = run.runner_up->scale;
  }
  if (!report.errors.empty()) {
    json["rotation_error_deg"] = report.errors[index].rotation_deg;
    json["translation_error"] = report.errors[index].translation;
    if (report.estimate_scale) json["scale_error"] = report.errors[index].scale;
  }
  return json;
}

// Standard deviations: of the rotation, and of the position where it is known best, at the inliers' weighted centre,
// that is given the rotation. At the origin of the source frame lever arms would hide it.
PoseErrors deviations(const PoseCovariance& covariance) {
  const Eigen::Matrix3d rotation = covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d joint = covariance.topRightCorner<3, 3>();
  const Eigen::Matrix3d position =
      covariance.bottomRightCorner<3, 3>() - joint.transpose() * rotation.ldlt().solve(joint);
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  return {kDegrees * std::sqrt(rotation.trace()), std::sqrt(std::max(position.trace(), 0.0))};
}

std::string run_text(const RegisterReport& report) {
  const Registration& run = report.runs.front();
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "status        {} (seed {})\n", to_string(run.status), run.seed);
  fmt::format_to(out, "inliers       {} within {:.4g} of the pose\n", run.inliers.size(), run.noise_bound);
  fmt::format_to(out, "by chance     10^{:.1f} poses of such support expected\n", run.log10_false_poses);
  if (run.runner_up) fmt::format_to(out, "runner-up     another motion has {} inliers\n", run.runner_up->support);
  fmt::format_to(out, "time          {:.3f} ms\n", 1e3 * run.seconds);
  for (const PoseErrors& error : report.errors) {
    fmt::format_to(out, "errors        rotation {:.4g} deg, translation {:.4g}\n", error.rotation_deg,
                   error.translation);
    if (report.estimate_scale) fmt::format_to(out, "              scale {:.4g} %\n", 100.0 * error.scale);
  }
  if (report.estimate_scale && run.has_pose()) {
    fmt::format_to(out, "scale         {:.10g} +- {:.2g}\n", run.scale, run.scale_deviation);
  }
  if (!run.covariance.isZero(0.0)) {
    const PoseErrors deviation = deviations(run.covariance);
    fmt::format_to(out, "deviation     rotation {:.4g} deg, position {:.4g} at the inliers' centre\n",
                   deviation.rotation_deg, deviation.translation);
  }
  if (run.has_pose()) {
    fmt::format_to(out, "T_target_source{}\n", report.estimate_scale ? " of the scaled source" : "");
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
  return studies::median(std::move(values));
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
    if (run.status == Status::ambiguous) fmt::format_to(out, "two poses     seed {}: ambiguous\n", run.seed);
  }
  fmt::format_to(out, "median        over all runs\n");
  fmt::format_to(out, "  inliers     {:g} within {:.4g} of the pose\n",
                 median_of(runs, [](const Registration& run) { return static_cast<double>(run.inliers.size()); }),
                 median_of(runs, [](const Registration& run) { return run.noise_bound; }));
  fmt::format_to(out, "  time        {:.3f} ms\n",
                 median_of(runs, [](const Registration& run) { return 1e3 * run.seconds; }));
  if (report.estimate_scale) {
    fmt::format_to(out, "  scale       {:.10g}\n", median_of(runs, [](const Registration& run) { return run.scale; }));
  }
  if (!report.errors.empty()) {
    fmt::format_to(out, "  errors      rotation {:.4g} deg, translation {:.4g}\n",
                   median_of(report.errors, [](const PoseErrors& error) { return error.rotation_deg; }),
                   median_of(report.errors, [](const PoseErrors& error) { return error.translation; }));
    if (report.estimate_scale) {
      fmt::format_to(out, "              scale {:.4g} %\n",
                     median_of(report.errors, [](const PoseErrors& error) { return 100.0 * error.scale; }));
    }
  }
  return fmt::to_string(text);
}

}  // namespace

std::string to_json(const RegisterReport& report) {
  Json head = {
      {"file", report.file},     {"correspondences", report.correspondences},
      {"isa", report.isa},       {"threads", report.threads},
      {"solver", report.solver}, {"noise_bound", report.noise_bound ? Json(*report.noise_bound) : Json(nullptr)}};
  if (!report.options.empty()) head["options"] = options_json(report.options);
  if (report.estimate_scale) head["estimate_scale"] = true;
  if (report.filter != Filter::none) head["filter"] = to_string(report.filter);
  std::string text = dump(head);
  text.pop_back();  // the closing brace: runs follow, each on a line of its own
  text += ",\n\"runs\":[";
  for (std::size_t i = 0; i < report.runs.size(); ++i) text += (i == 0 ? "\n" : ",\n") + dump(run_json(report, i));
  return text + "\n]}\n";
}

std::string to_text(const RegisterReport& report) {
  std::string solver = report.solver;
  for (const OptionSetting& option : report.options) {
    solver += fmt::format(":{}={}", option.name, to_string(option.value));
  }
  return fmt::format(
             "file          {}, {} correspondences (lengths below are in its unit)\n"
             "solver        {}{}, noise bound {}, {} on {} thread{}\n",
             report.file, report.correspondences, solver,
             report.filter == Filter::none ? "" : fmt::format(" after filter {}", to_string(report.filter)),
             report.noise_bound ? fmt::format("{}", *report.noise_bound) : "estimated", report.isa, report.threads,
             report.threads == 1 ? "" : "s") +
         (report.runs.size() == 1 ? run_text(report) : summary_text(report));
}

}  // namespace consimd::cli
