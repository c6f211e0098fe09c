#include <consimd/studies/registration_picture.hpp>

#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <consimd/synth/metrics.hpp>

#include "pictures/page_sources.hpp"
#include "pictures/page_text.hpp"
#include "pictures/scene.hpp"
#include "pictures/status_meaning.hpp"

namespace consimd::studies {
namespace {

// More than a screen has pixels for; both clouds make a page of 7 MB.
constexpr std::size_t kMostPoints = 200'000;
constexpr std::size_t kMostLines = 10'000;  // of a kind
constexpr std::size_t kLinesAtFirst = 400;  // of a kind: more hide the clouds

std::string short_name(const std::string& name) { return std::filesystem::path(name).filename().string(); }

std::string title(const RegistrationPicture& picture) {
  std::string names = escaped(short_name(picture.source_name));
  if (!picture.target_name.empty()) names += " \xe2\x86\x92 " + escaped(short_name(picture.target_name));
  return names;
}

std::string heading(const RegistrationPicture& picture) {
  if (picture.target_name.empty()) return escaped(short_name(picture.source_name));
  return fmt::format(R"(<span class="source">{}</span> &rarr; <span class="target">{}</span>)",
                     escaped(short_name(picture.source_name)), escaped(short_name(picture.target_name)));
}

std::string pose_rows(const RigidTransform& pose) {
  std::string rows;
  for (Eigen::Index row = 0; row < 4; ++row) {
    const Eigen::Vector4d v = pose.matrix().row(row);
    rows +=
        fmt::format("<tr><td>{:.6f}</td><td>{:.6f}</td><td>{:.6f}</td><td>{:.9g}</td></tr>\n", v[0], v[1], v[2], v[3]);
  }
  return rows;
}

/// The legend: everything that the picture is of, for readers without WebGL as well.
std::string facts(const RegistrationPicture& picture) {
  const Registration& run = *picture.registration;
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "<h1>{}</h1>\n<span class=\"status {}\">{}</span>\n<p class=\"meaning\">{}</p>\n<table>\n",
                 heading(picture), to_string(run.status), to_string(run.status), meaning(run.status));
  const auto row = [&out](std::string_view name, const std::string& value) {
    fmt::format_to(out, "<tr><th>{}</th><td>{}</td></tr>\n", name, value);
  };
  if (picture.target_name.empty()) {
    row("file", escaped(picture.source_name));
  } else {
    row("source", escaped(picture.source_name));
    row("target", escaped(picture.target_name));
  }
  if (!picture.solver.empty()) row("solver", escaped(picture.solver));
  const std::size_t rows = picture.correspondences->size();
  row("correspondences", grouped(rows));
  row("noise bound", fmt::format("{:.4g}", run.noise_bound));
  if (run.has_pose()) {
    row("inliers", fmt::format("{} ({:.3g} %)", grouped(run.inliers.size()),
                               100.0 * static_cast<double>(run.inliers.size()) / static_cast<double>(rows)));
    row("by chance", fmt::format("10<sup>{:.1f}</sup> such poses", run.log10_false_poses));
    if (run.runner_up) row("runner-up", fmt::format("{} inliers", grouped(run.runner_up->support)));
    const double angle = synth::rotation_error_deg(run.T_target_source, RigidTransform::Identity());
    row("rotation", fmt::format("{:.4g}&deg;", angle));
    row("translation", fmt::format("{:.6g}", run.T_target_source.translation().norm()));
    if (run.scale != 1.0) row("scale", fmt::format("{:.8g}", run.scale));
    fmt::format_to(out, "</table>\n<table class=\"pose\">\n<caption>T_target_source</caption>\n{}",
                   pose_rows(run.T_target_source));
  }
  fmt::format_to(out, "</table>");
  return fmt::to_string(text);
}

std::string thinned(std::string_view name, const SceneCloud& cloud) {
  if (cloud.points.size() == cloud.size) return {};
  if (cloud.voxel > 0.0) {
    return fmt::format("<li>{}: {} points drawn, the means of voxels of {:.3g}</li>\n", name,
                       grouped(cloud.points.size()), cloud.voxel);
  }
  return fmt::format("<li>{}: {} of {} points drawn</li>\n", name, grouped(cloud.points.size()), grouped(cloud.size));
}

std::string thinned(std::string_view name, const SceneLines& lines) {
  if (lines.drawn.size() == lines.size) return {};
  return fmt::format("<li>{}: {} of {} lines drawn, evenly chosen</li>\n", name, grouped(lines.drawn.size()),
                     grouped(lines.size));
}

/// What the picture does not show as it is.
std::string notes(const RegistrationPicture& picture, const Scene& scene) {
  std::string items = thinned("source", scene.source) + thinned("target", scene.target);
  const bool pose = picture.registration->has_pose();
  items += thinned("inliers", scene.inliers) + thinned(pose ? "outliers" : "correspondences", scene.outliers);
  if (scene.far_rows > 0) {
    items += fmt::format("<li>{} correspondences far from all others are not drawn</li>\n", grouped(scene.far_rows));
  }
  if (scene.gap > 0.0) {
    items += fmt::format("<li>before: the source is drawn {:.4g} nearer to the target than it is</li>\n", scene.gap);
  }
  return items.empty() ? items : "<ul class=\"notes\">\n" + items + "</ul>";
}

Json cloud_json(const SceneCloud& cloud) {
  const std::span numbers(cloud.points.data()->data(), 3 * cloud.points.size());
  return {{"size", cloud.size}, {"origin", cloud.origin}, {"points", base64_floats(numbers)}};
}

Json lines_json(const SceneLines& lines) {
  static_assert(sizeof(SceneLine) == 6 * sizeof(float));
  std::vector<float> numbers;
  numbers.reserve(6 * lines.drawn.size());
  for (const SceneLine& line : lines.drawn) {
    for (const ScenePoint* const p : {&line.source, &line.target}) numbers.insert(numbers.end(), p->begin(), p->end());
  }
  return {{"size", lines.size}, {"lines", base64_floats(numbers)}};
}

Json placement_json(const Placement& placement) {
  const Eigen::Matrix4d matrix = placement.T_target_source.matrix();  // column-major, as WebGL takes it
  return {{"name", placement.name},
          {"matrix", std::vector<double>(matrix.data(), matrix.data() + 16)},
          {"focus", std::vector<double>(placement.focus.data(), placement.focus.data() + 3)},
          {"radius", placement.radius}};
}

Json scene_json(const RegistrationPicture& picture, const Scene& scene) {
  Json json = {{"pose", picture.registration->has_pose()},
               {"view",
                {{"yaw", kYaw},
                 {"pitch", kPitch},
                 {"field", kField},
                 {"up", std::vector<double>(scene.up.data(), scene.up.data() + 3)},
                 {"lines", kLinesAtFirst},
                 // Matched points are few; those of scans shall make surfaces.
                 {"point_size", picture.source == nullptr ? 3.5 : 2.0}}},
               {"source", cloud_json(scene.source)},
               {"target", cloud_json(scene.target)},
               {"inliers", lines_json(scene.inliers)},
               {"outliers", lines_json(scene.outliers)},
               {"placements", Json::array()}};
  for (const Placement& placement : scene.placements) json["placements"].push_back(placement_json(placement));
  return json;
}

}  // namespace

std::string registration_page(const RegistrationPicture& picture) {
  const Scene scene = make_scene(picture, kMostPoints, kMostLines);
  const std::string name = title(picture), legend = facts(picture), remarks = notes(picture, scene);
  const std::string data = page_json(scene_json(picture, scene));
  const std::array<std::pair<std::string_view, std::string_view>, 6> values{
      {{"title", name},
       {"body", picture.registration->has_pose() ? "" : " class=\"plain\""},
       {"facts", legend},
       {"notes", remarks},
       {"data", data},
       {"script", kRegistrationScript}}};
  return filled(kRegistrationPage, values);
}

}  // namespace consimd::studies
