#include "register_report.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>
#include <utility>

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

Json stages_json(const std::vector<StageReport>& reports) {
  Json stages = Json::array();
  for (const StageReport& stage : reports) {
    stages.push_back({{"name", stage.name},
                      {"input", stage.input},
                      {"output", stage.output},
                      {"iterations", stage.iterations},
                      {"seconds", stage.seconds}});
  }
  return stages;
}

Json cloud_json(const features::CloudSummary& cloud) {
  return {{"points", cloud.points},
          {"left_out", cloud.left_out},
          {"voxels", cloud.voxels},
          {"descriptors", cloud.descriptors},
          {"resolution", std::isfinite(cloud.resolution) ? Json(cloud.resolution) : Json(nullptr)}};
}

Json viewpoint_json(const Viewpoint& viewpoint) { return viewpoint ? Json(*viewpoint) : Json(nullptr); }

Json refinement_json(const std::optional<features::Refinement>& refinement) {
  if (!refinement) return nullptr;
  return {{"status", to_string(refinement->status)},
          {"iterations", refinement->iterations},
          {"pairs", refinement->pairs},
          {"inlier_share", refinement->inlier_share},
          {"rmse", refinement->rmse},
          {"residual_scale", refinement->residual_scale},
          {"shared_errors", refinement->shared_errors},
          {"max_distance", refinement->max_distance},
          {"seconds", refinement->seconds}};
}

Json pose_json(const RunnerUp& pose, bool estimate_scale) {
  Json json = {{"support", pose.support},
               {"log10_false_poses", pose.log10_false_poses},
               {"T_target_source", rows_of(pose.T_target_source.matrix())}};
  if (estimate_scale) json["scale"] = pose.scale;
  return json;
}

Json evidence_json(const features::PoseEvidence& evidence) {
  Json json = {{"log10_chance", evidence.log10_chance},
               {"agreement", evidence.agreement},
               {"seen_through", evidence.seen_through},
               {"samples", evidence.samples},
               {"displaced_agreement", evidence.displaced_agreement},
               {"displaced_seen_through", evidence.displaced_seen_through},
               {"fitted_agreement", evidence.fitted_agreement},
               {"fitted_seen_through", evidence.fitted_seen_through},
               {"scale", evidence.scaled.scale},
               {"gain_by_scale", evidence.scaled.gain},
               {"rival", nullptr}};
  if (evidence.rival) {
    json["rival"] = {{"share_of_score", evidence.rival->share_of_score},
                     {"share_of_agreement", evidence.rival->share_of_agreement},
                     {"agreement", evidence.rival->agreement},
                     {"seen_through", evidence.rival->seen_through},
                     {"T_target_source", rows_of(evidence.rival->T_target_source.matrix())}};
  }
  return json;
}

Json verdict_json(const features::CloudVerdict& verdict) {
  Json json = {{"of_correspondences", to_string(verdict.of_correspondences)},
               {"found_by_clouds", verdict.found_by_clouds},
               {"pose", verdict.pose ? evidence_json(*verdict.pose) : Json(nullptr)}};
  if (verdict.runner_up) json["runner_up"] = evidence_json(*verdict.runner_up);
  return json;
}

Json run_json(const RegisterReport& report, std::size_t index) {
  const Registration& run = report.runs[index];
  Json json = {{"seed", run.seed},
               {"status", to_string(run.status)},
               {"noise_bound", run.noise_bound},
               {"log10_false_poses", run.log10_false_poses},
               {"T_target_source", run.has_pose() ? rows_of(run.T_target_source.matrix()) : Json(nullptr)},
               {"covariance", run.has_pose() ? rows_of(run.covariance) : Json(nullptr)},
               {"inlier_count", run.inliers.size()},
               {"inliers", run.inliers},
               {"seconds", run.seconds},
               {"stopped", run.stopped},
               {"stages", stages_json(run.stages)}};
  const auto of_pose = [&run](double value) { return run.has_pose() ? Json(value) : Json(nullptr); };
  if (report.estimate_scale) {
    json["scale"] = of_pose(run.scale);
    json["scale_deviation"] = of_pose(run.scale_deviation);
  }
  if (report.assumed_inliers && run.has_pose()) {
    json["residuals"] = report.residuals;
    json["sigma"] = report.sigma;
  }
  if (!report.refinements.empty()) json["refinement"] = refinement_json(report.refinements[index]);
  if (run.runner_up) json["runner_up"] = pose_json(*run.runner_up, report.estimate_scale);
  if (run.refused) json["refused"] = pose_json(*run.refused, report.estimate_scale);
  if (!report.verdicts.empty()) json["verification"] = verdict_json(report.verdicts[index]);
  if (!report.attempts.empty()) json["attempts"] = report.attempts[index];
  if (!report.errors.empty()) {
    json["rotation_error_deg"] = of_pose(report.errors[index].rotation_deg);
    json["translation_error"] = of_pose(report.errors[index].translation);
    if (report.estimate_scale) json["scale_error"] = of_pose(report.errors[index].scale);
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

std::string verdict_text(const features::CloudVerdict& verdict, const Registration& run) {
  if (!verdict.pose) return {};
  if (verdict.pose->samples == 0) return "clouds        have no surfaces to hold the pose against\n";
  std::string text =
      fmt::format("clouds        agree at {:.0f} % of {} places, see through {:.1f} %; 10^{:.1f} by chance\n",
                  100.0 * verdict.pose->agreement, verdict.pose->samples, 100.0 * verdict.pose->seen_through,
                  verdict.pose->log10_chance);
  if (run.status == Status::ambiguous && features::has_equal_rival(*verdict.pose)) {
    text += fmt::format("              and at another pose as well, by {:.0f} % of the score\n",
                        100.0 * verdict.pose->rival->share_of_score);
  }
  if (verdict.runner_up) {
    text += fmt::format("              at the runner-up's pose at {:.0f} %, see through {:.1f} %\n",
                        100.0 * verdict.runner_up->agreement, 100.0 * verdict.runner_up->seen_through);
  }
  if (features::agrees_better_scaled(*verdict.pose)) {
    text += fmt::format("              and {:.2f} times as well with the source scaled by {:.4g}: of one scale?\n",
                        verdict.pose->scaled.gain, verdict.pose->scaled.scale);
  }
  if (verdict.found_by_clouds) {
    text += fmt::format("              and gave the pose: the one of the correspondences ({}) led to it\n",
                        to_string(verdict.of_correspondences));
  } else if (verdict.of_correspondences != run.status) {
    text += fmt::format("              and decide: the correspondences alone gave {}\n",
                        to_string(verdict.of_correspondences));
  }
  return text;
}

// More than a page of them is for a program to read.
constexpr std::size_t kResidualsShown = 40;

std::string run_text(const RegisterReport& report) {
  const Registration& run = report.runs.front();
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  if (report.assumed_inliers) {
    fmt::format_to(out, "status        {} (all rows assumed to be inliers)\n", to_string(run.status));
    if (run.has_pose()) {
      fmt::format_to(out, "residuals     deviation {:.4g} per axis, largest {:.4g}\n", report.sigma, run.noise_bound);
    }
  } else {
    fmt::format_to(out, "status        {} (seed {})\n", to_string(run.status), run.seed);
    if (run.has_pose()) {
      fmt::format_to(out, "inliers       {} within {:.4g} of the pose\n", run.inliers.size(), run.noise_bound);
    } else if (run.refused) {
      fmt::format_to(out, "best met      a pose with {} rows within {:.4g}\n", run.refused->support, run.noise_bound);
    }
    if (run.has_pose() || run.refused) {
      fmt::format_to(out, "by chance     10^{:.1f} poses of such support expected at most\n", run.log10_false_poses);
    }
  }
  if (run.runner_up) fmt::format_to(out, "runner-up     another motion has {} inliers\n", run.runner_up->support);
  if (!report.verdicts.empty()) fmt::format_to(out, "{}", verdict_text(report.verdicts.front(), run));
  if (!report.attempts.empty() && report.attempts.front() > 1) {
    fmt::format_to(out, "attempts      {}, this one with voxels of {:.4g}\n", report.attempts.front(),
                   report.clouds->voxel);
  }
  if (!report.refinements.empty() && report.refinements.front()) {
    const features::Refinement& refinement = *report.refinements.front();
    fmt::format_to(out,
                   "refinement    {} after {} steps: {} pairs within {:.4g}, {:.1f} % of the source, rmse {:.4g}{}\n",
                   to_string(refinement.status), refinement.iterations, refinement.pairs, refinement.max_distance,
                   100.0 * refinement.inlier_share, refinement.rmse,
                   refinement.has_pose() ? "" : "; the pose is that of the correspondences");
  }
  fmt::format_to(out, "time          {:.3f} ms{}\n", 1e3 * run.seconds,
                 run.stopped ? ", the search was ended by the time limit" : "");
  for (const PoseErrors& error : report.errors) {
    if (!run.has_pose()) break;
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
  for (std::size_t row = 0; row < std::min(report.residuals.size(), kResidualsShown); ++row) {
    fmt::format_to(out, "row {:<9} residual {:.4g}\n", row, report.residuals[row]);
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
  if (!report.refinements.empty()) {
    const auto converged = std::count_if(report.refinements.begin(), report.refinements.end(),
                                         [](const auto& refinement) { return refinement && refinement->has_pose(); });
    fmt::format_to(out, "  refined     {} of the {} with a pose\n", converged, found);
  }
  if (!report.errors.empty() && found > 0) {
    std::vector<PoseErrors> errors;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (runs[i].has_pose()) errors.push_back(report.errors[i]);
    }
    fmt::format_to(out, "  errors      rotation {:.4g} deg, translation {:.4g}{}\n",
                   median_of(errors, [](const PoseErrors& error) { return error.rotation_deg; }),
                   median_of(errors, [](const PoseErrors& error) { return error.translation; }),
                   errors.size() == runs.size() ? "" : fmt::format(" (of the {} with a pose)", errors.size()));
    if (report.estimate_scale) {
      fmt::format_to(out, "              scale {:.4g} %\n",
                     median_of(errors, [](const PoseErrors& error) { return 100.0 * error.scale; }));
    }
  }
  return fmt::to_string(text);
}

// What people are told, in the names of the command's options.
std::vector<std::string> notes_of(const RegisterReport& report) {
  std::vector<std::string> notes = report.notes;
  for (std::string& note : notes) {
    for (const auto& [option, flag] :
         {std::pair("estimate_scale", "--estimate-scale"), std::pair("assume_inliers", "--assume-inliers")}) {
      if (const std::size_t at = note.find(option); at != std::string::npos) {
        note.replace(at, std::string_view(option).size(), flag);
      }
    }
  }
  if (report.truth_inverted) {
    notes.emplace_back("the rows support the inverse of --truth, not itself: it must take source points to the target");
  }
  return notes;
}

std::string notes_text(const RegisterReport& report) {
  std::string text;
  for (const std::string& note : notes_of(report)) text += fmt::format("note          {}\n", note);
  return text;
}

}  // namespace

std::string to_json(const RegisterReport& report) {
  Json head = {
      {"file", report.file},     {"correspondences", report.correspondences},
      {"isa", report.isa},       {"threads", report.threads},
      {"solver", report.solver}, {"noise_bound", report.noise_bound ? Json(*report.noise_bound) : Json(nullptr)}};
  if (report.clouds) {
    head["clouds"] = {{"source", cloud_json(report.clouds->source)},
                      {"target", cloud_json(report.clouds->target)},
                      {"voxel", report.clouds->voxel},
                      {"keypoints", report.cloud_arguments.keypoints},
                      {"matches", report.cloud_arguments.matches},
                      {"source_viewpoint", viewpoint_json(source_viewpoint_of(report.cloud_arguments))},
                      {"target_viewpoint", viewpoint_json(target_viewpoint_of(report.cloud_arguments))},
                      {"hint", report.clouds->hint},
                      {"stages", stages_json(report.clouds->stages)}};
  }
  if (report.row_viewpoint) head["source_viewpoint"] = *report.row_viewpoint;
  if (!report.options.empty()) head["options"] = options_json(report.options);
  if (report.cloud_arguments.refine) head["refine"] = *report.cloud_arguments.refine;
  if (report.estimate_scale) head["estimate_scale"] = true;
  if (report.filter != Filter::none) head["filter"] = to_string(report.filter);
  if (report.assumed_inliers) head["assume_inliers"] = true;
  if (const std::vector<std::string> notes = notes_of(report); !notes.empty()) head["notes"] = notes;
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
             report.noise_bound       ? fmt::format("{}", *report.noise_bound)
             : report.assumed_inliers ? "none"
                                      : "estimated",
             report.isa, report.threads, report.threads == 1 ? "" : "s") +
         (report.clouds
              ? to_text(*report.clouds, report.cloud_arguments, report.noise_bound != report.clouds->noise_bound)
              : std::string()) +
         notes_text(report) + (report.runs.size() == 1 ? run_text(report) : summary_text(report));
}

}  // namespace consimd::cli
