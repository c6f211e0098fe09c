#include <consimd/studies/registration_picture.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pictures/page_text.hpp"
#include "pictures/scene.hpp"
#include "pictures/status_meaning.hpp"

namespace consimd::studies {
namespace {

constexpr std::size_t kMostPoints = 5000;
constexpr std::size_t kMostLines = 200;  // of a kind

// Of a panel, in SVG's units; the caption lies below all of them.
constexpr double kWidth = 480.0;
constexpr double kHeight = 400.0;
constexpr double kCaption = 74.0;

constexpr std::string_view kSource = "#ffb347";
constexpr std::string_view kTarget = "#58a6ff";
constexpr std::string_view kInlier = "#3ddc84";
constexpr std::string_view kOutlier = "#ff4757";
constexpr std::string_view kPlain = "#9aa7b8";

struct Projected {
  double x = 0.0;
  double y = 0.0;
  double depth = 0.0;  ///< from the eye; below 0: behind it
};

/// The camera of the page when it opens, nearer: far points, of which there are few in the page, weigh more in the
/// means of large voxels.
class Camera {
 public:
  Camera(const Placement& placement, const Eigen::Vector3d& up)
      : focus_(placement.focus), reach_(0.8 * placement.radius / std::sin(kField / 2.0)) {
    // As in registration_page.js.
    const Eigen::Vector3d x = std::abs(up.x()) > 0.5 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
    const Eigen::Vector3d y = up.cross(x);
    back_ = std::cos(kPitch) * (std::cos(kYaw) * x + std::sin(kYaw) * y) + std::sin(kPitch) * up;
    right_ = up.cross(back_).normalized();
    above_ = back_.cross(right_);
  }

  [[nodiscard]] Projected operator()(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d from_focus = p - focus_;
    const double depth = reach_ - from_focus.dot(back_);
    const double scale = std::min(kWidth, kHeight) / 2.0 / std::tan(kField / 2.0) / depth;
    return {kWidth / 2.0 + scale * from_focus.dot(right_), kHeight / 2.0 - scale * from_focus.dot(above_), depth};
  }
  [[nodiscard]] double reach() const noexcept { return reach_; }

 private:
  Eigen::Vector3d focus_, back_, right_, above_;
  double reach_ = 1.0;
};

Eigen::Vector3d vector(const ScenePoint& p) { return Eigen::Vector3f(p[0], p[1], p[2]).cast<double>(); }

bool is_inside(const Projected& p) { return p.depth > 0.0 && p.x > 0.0 && p.x < kWidth && p.y > 0.0 && p.y < kHeight; }

// Slices of depth, the farthest first and dimmest: what depth is to the eye.
constexpr std::size_t kSlices = 6;

using Slices = std::array<std::string, kSlices>;

Slices slices_of(const std::vector<ScenePoint>& points, const Eigen::Affine3d& T, const Camera& camera) {
  Slices slices;
  for (const ScenePoint& point : points) {
    const Projected p = camera(T * vector(point));
    if (!is_inside(p)) continue;
    const double place = (1.5 - p.depth / camera.reach()) * static_cast<double>(kSlices);  // 0.5 to 1.5 of the reach
    const auto slice = static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(kSlices - 1)));
    fmt::format_to(std::back_inserter(slices[slice]), "M{:.1f} {:.1f}h0", p.x, p.y);
  }
  return slices;
}

std::string line_path(const SceneLines& lines, const Eigen::Affine3d& T, const Camera& camera) {
  std::string path;
  for (const SceneLine& line : lines.drawn) {
    const Projected p = camera(T * vector(line.source)), q = camera(vector(line.target));
    if (is_inside(p) && is_inside(q)) {
      fmt::format_to(std::back_inserter(path), "M{:.1f} {:.1f}L{:.1f} {:.1f}", p.x, p.y, q.x, q.y);
    }
  }
  return path;
}

std::string panel(const Scene& scene, const Placement& placement, bool pose, double size) {
  const Camera camera(placement, scene.up);
  const Slices source = slices_of(scene.source.points, placement.T_target_source, camera);
  const Slices target = slices_of(scene.target.points, Eigen::Affine3d::Identity(), camera);
  std::string text;
  const auto out = std::back_inserter(text);
  for (std::size_t slice = 0; slice < kSlices; ++slice) {
    const double opacity = 0.35 + 0.65 * static_cast<double>(slice) / static_cast<double>(kSlices - 1);
    for (const auto& [path, colour] : {std::pair(&target[slice], kTarget), std::pair(&source[slice], kSource)}) {
      if (path->empty()) continue;
      fmt::format_to(out, "<path d=\"{}\" stroke=\"{}\" stroke-width=\"{}\" stroke-opacity=\"{:.2f}\"/>\n", *path,
                     colour, size, opacity);
    }
  }
  const std::string wrong = line_path(scene.outliers, placement.T_target_source, camera);
  const std::string right = line_path(scene.inliers, placement.T_target_source, camera);
  if (!wrong.empty()) {
    fmt::format_to(out, "<path d=\"{}\" stroke=\"{}\" stroke-width=\"0.7\" stroke-opacity=\"0.45\"/>\n", wrong,
                   pose ? kOutlier : kPlain);
  }
  if (!right.empty()) {
    // Lines shorter than they are wide are dots, by their round ends.
    fmt::format_to(out, "<path d=\"{}\" stroke=\"{}\" stroke-width=\"1.6\"/>\n", right, kInlier);
  }
  fmt::format_to(out, "<text x=\"14\" y=\"26\" class=\"placement\">{}</text>\n",
                 pose ? std::string_view(placement.name) : std::string_view("as given"));
  return text;
}

/// Words behind one another, each with its colour's dot.
std::string legend(const Scene& scene, bool pose) {
  std::string text;
  double x = 14.0;
  const auto add = [&text, &x](std::string_view colour, const std::string& words) {
    fmt::format_to(std::back_inserter(text),
                   "<circle cx=\"{}\" cy=\"-4\" r=\"4\" fill=\"{}\"/><text x=\"{}\">{}</text>\n", x + 4.0, colour,
                   x + 13.0, words);
    x += 33.0 + 6.6 * static_cast<double>(words.size());
  };
  add(kSource, "source");
  add(kTarget, "target");
  if (pose) {
    add(kInlier, fmt::format("{} inliers", scene.inliers.size));
    add(kOutlier, fmt::format("{} outliers", scene.outliers.size));
  } else {
    add(kPlain, fmt::format("{} correspondences", scene.outliers.size));
  }
  return text;
}

std::string caption(const RegistrationPicture& picture) {
  const Registration& run = *picture.registration;
  std::string names = escaped(picture.source_name);
  if (!picture.target_name.empty()) names += " \xe2\x86\x92 " + escaped(picture.target_name);
  return fmt::format(
      "<text x=\"14\" y=\"24\" class=\"name\">{}</text>\n<text x=\"14\" y=\"44\">{}: {}; noise bound {:.4g}</text>\n",
      names, to_string(run.status), meaning(run.status), run.noise_bound);
}

}  // namespace

std::string registration_svg(const RegistrationPicture& picture) {
  const Scene scene = make_scene(picture, kMostPoints, kMostLines);
  const bool pose = picture.registration->has_pose();
  const std::size_t panels = std::min<std::size_t>(scene.placements.size(), 2);
  const double width = kWidth * static_cast<double>(panels);
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(
      out,
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"system-ui, Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#dbe4ee\">\n"
      "<style>path {{ fill: none; stroke-linecap: round }} .placement {{ font-size: 17px; font-weight: 600 }} "
      ".name {{ font-weight: 600 }}</style>\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#0c1118\"/>\n",
      width, kHeight + kCaption);
  for (std::size_t i = 0; i < panels; ++i) {
    const double left = kWidth * static_cast<double>(i);
    fmt::format_to(out, "<g transform=\"translate({} 0)\">\n{}</g>\n", left,
                   panel(scene, scene.placements[i], pose, picture.source == nullptr ? 2.6 : 1.8));
    if (i > 0) fmt::format_to(out, "<path d=\"M{0} 0V{1}\" stroke=\"#263242\"/>\n", left, kHeight);
  }
  fmt::format_to(out, "<path d=\"M0 {0}H{1}\" stroke=\"#263242\"/>\n<g transform=\"translate(0 {0})\">\n{2}", kHeight,
                 width, caption(picture));
  fmt::format_to(out, "<g transform=\"translate(0 64)\">\n{}</g></g>\n</svg>\n", legend(scene, pose));
  return text;
}

}  // namespace consimd::studies
