#include <consimd/kernels/pcl_correspondences.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace consimd::test {
namespace {

// The parts of the Point Cloud Library's types that matter here.
struct alignas(16) PointXYZ {
  union {
    float data[4];
    struct {
      float x;
      float y;
      float z;
    };
  };
};

struct alignas(16) PointNormal {
  float x, y, z, padding;
  float normal_x, normal_y, normal_z, curvature;
};

template <typename Point>
struct Cloud {
  std::vector<Point> points;
};

template <typename Index>
struct Match {
  Index index_query;
  Index index_match;
  float distance;
};
using Matches = std::vector<Match<int>>;

template <typename Point>
Cloud<Point> curve(std::size_t n, float shift) {
  Cloud<Point> cloud;
  cloud.points.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto s = static_cast<float>(i);
    cloud.points[i].x = shift + s;
    cloud.points[i].y = shift + std::sin(s);
    cloud.points[i].z = shift + 0.25f * s * s;
  }
  return cloud;
}

const Cloud<PointXYZ>& source() {
  static const auto cloud = curve<PointXYZ>(10, 0.0f);
  return cloud;
}

const Cloud<PointNormal>& target() {
  static const auto cloud = curve<PointNormal>(12, 3.0f);
  return cloud;
}

double original(const Correspondences& c, std::size_t axis, std::size_t row) {
  return double{c.view().source(axis)[row]} / c.scale() + c.source_centroid()[axis];
}

double image(const Correspondences& c, std::size_t axis, std::size_t row) {
  return double{c.view().target(axis)[row]} / c.scale() + c.target_centroid()[axis];
}

TEST(PclCorrespondences, FollowTheMatches) {
  const Matches matches{{9, 0, 0.1f}, {0, 11, 0.2f}, {4, 4, 0.3f}, {4, 5, 0.4f}};
  const Correspondences c = pcl_correspondences(source(), target(), matches);
  ASSERT_EQ(c.size(), matches.size());
  for (std::size_t k = 0; k < matches.size(); ++k) {
    const PointXYZ& p = source().points[static_cast<std::size_t>(matches[k].index_query)];
    const PointNormal& q = target().points[static_cast<std::size_t>(matches[k].index_match)];
    EXPECT_NEAR(original(c, 0, k), p.x, 1e-5);
    EXPECT_NEAR(original(c, 1, k), p.y, 1e-5);
    EXPECT_NEAR(original(c, 2, k), p.z, 1e-5);
    EXPECT_NEAR(image(c, 0, k), q.x, 1e-5);
    EXPECT_NEAR(image(c, 1, k), q.y, 1e-5);
    EXPECT_NEAR(image(c, 2, k), q.z, 1e-5);
  }
  EXPECT_TRUE(pcl_correspondences(source(), target(), Matches{}).empty());
}

TEST(PclCorrespondences, PairCloudsRowByRow) {
  const auto moved = curve<PointNormal>(10, 3.0f);
  const Correspondences c = pcl_correspondences(source(), moved);
  ASSERT_EQ(c.size(), 10u);
  EXPECT_NEAR(original(c, 2, 9), source().points[9].z, 1e-5);
  EXPECT_NEAR(image(c, 2, 9), moved.points[9].z, 1e-5);
  EXPECT_THROW((void)pcl_correspondences(source(), target()), std::invalid_argument);
}

template <typename Index>
std::string message_of(const std::vector<Match<Index>>& matches) {
  try {
    (void)pcl_correspondences(source(), target(), matches);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(PclCorrespondences, NameTheBadRow) {
  EXPECT_EQ(message_of<int>({{0, 0, 0}, {1, -1, 0}}),
            "match 1: index_match is -1, expected a point of the target cloud, which has 12");
  EXPECT_EQ(message_of<int>({{10, 0, 0}}),
            "match 0: index_query is 10, expected a point of the source cloud, which has 10");
  // PCL can be built with other index types.
  EXPECT_EQ(message_of<std::uint32_t>({{0, 0, 0}, {1, 0, 0}, {2, 12, 0}}),
            "match 2: index_match is 12, expected a point of the target cloud, which has 12");
  EXPECT_EQ(message_of<std::int64_t>({{std::int64_t{1} << 32, 0, 0}}),
            "match 0: index_query is 4294967296, expected a point of the source cloud, which has 10");
}

TEST(PclCorrespondences, RejectPointsThatAreNotThere) {
  auto holes = source();
  holes.points[3].y = std::nanf("");
  try {
    (void)pcl_correspondences(holes, target(), Matches{{0, 0, 0}, {3, 3, 0}});
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "source point 1: coordinate y is nan, expected a finite number");
  }
}

TEST(PclCorrespondences, SubsetsKeepWhatMatchesHold) {
  const Matches matches{{9, 0, 0.1f}, {0, 11, 0.2f}, {4, 4, 0.3f}};
  const std::vector<std::uint32_t> rows{2, 0};
  const Matches chosen = matches_subset(matches, rows);
  ASSERT_EQ(chosen.size(), 2u);
  EXPECT_EQ(chosen[0].index_query, 4);
  EXPECT_EQ(chosen[0].distance, 0.3f);
  EXPECT_EQ(chosen[1].index_match, 0);
  EXPECT_TRUE(matches_subset(matches, {}).empty());
  EXPECT_THROW((void)matches_subset(matches, std::vector<std::uint32_t>{3}), std::out_of_range);
}

}  // namespace
}  // namespace consimd::test
