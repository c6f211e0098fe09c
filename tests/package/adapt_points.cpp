// The same points as structs, as matrices, and as clouds with matches of the Point Cloud Library's shape: one pose.
#include <Eigen/Geometry>

#include <iostream>
#include <vector>

#include <consimd/consimd.hpp>
#include <consimd/kernels/pcl_correspondences.hpp>

static_assert(CONSIMD_VERSION == 10000 * CONSIMD_VERSION_MAJOR + 100 * CONSIMD_VERSION_MINOR + CONSIMD_VERSION_PATCH);

namespace {

struct alignas(16) Point {
  float x, y, z;
};
struct Cloud {
  std::vector<Point> points;
};
struct Match {
  int index_query, index_match;
};

constexpr int kPoints = 200;

bool same(const consimd::Registration& a, const consimd::Registration& b) {
  return a.has_pose() && a.T_target_source.matrix() == b.T_target_source.matrix() && a.inliers == b.inliers;
}

}  // namespace

int main() {
  const Eigen::Isometry3f truth =
      Eigen::Translation3f(5, -3, 2) * Eigen::Quaternionf(0.5f, 0.1f, -0.7f, 0.3f).normalized();
  Cloud source;
  Cloud target;
  std::vector<Match> matches;
  for (int i = 0; i < kPoints; ++i) {
    const auto s = static_cast<float>(i);
    const Eigen::Vector3f p(10 * std::sin(s), 10 * std::cos(1.7f * s), std::fmod(0.3f * s, 7.0f));
    const Eigen::Vector3f q = i % 3 == 0 ? Eigen::Vector3f(p[1], p[2], -p[0]) : truth * p;
    source.points.push_back({p[0], p[1], p[2]});
    target.points.push_back({q[0], q[1], q[2]});
    matches.push_back({i, i});
  }
  using Rows = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>, 0, Eigen::OuterStride<4>>;
  const Rows p(&source.points[0].x, kPoints, 3);
  const Rows q(&target.points[0].x, kPoints, 3);

  const consimd::TcfOptions options{.noise_bound = 0.01};
  const auto structs =
      consimd::register_tcf({consimd::range_points(source.points), consimd::range_points(target.points)}, options);
  const auto ranges = consimd::register_tcf(source.points, target.points, options);
  const auto by_name = consimd::register_by_name("tcf", p, q, {.noise_bound = 0.01, .threads = 1});
  const auto matrices = consimd::register_tcf({consimd::row_points(p), consimd::row_points(q)}, options);
  const auto matched = consimd::register_tcf(consimd::pcl_correspondences(source, target, matches), options);
  const std::vector<Match> inliers = consimd::matches_subset(matches, matched.inliers);

  const Eigen::Isometry3d pose = structs.T_target_source;
  std::cout << consimd::to_string(structs.status) << ", " << inliers.size() << " inliers\n";
  return same(structs, ranges) && same(structs, by_name) && same(structs, matrices) && same(structs, matched) &&
                 inliers.size() == structs.inliers.size() && pose.isApprox(truth.cast<double>(), 1e-5)
             ? 0
             : 1;
}
