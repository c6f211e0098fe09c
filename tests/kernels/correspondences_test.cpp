#include <consimd/kernels/correspondences.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

std::vector<double> any_points(std::size_t n, double magnitude, double offset, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<double> points(3 * n);
  for (double& x : points) x = offset + magnitude * double{uniform(random)};
  return points;
}

void expect_same(const Correspondences& a, const Correspondences& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.scale(), b.scale());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a.view().source(axis)[i], b.view().source(axis)[i]);
      EXPECT_EQ(a.view().target(axis)[i], b.view().target(axis)[i]);
    }
  }
}

TEST(Correspondences, AreTheSameFromAnyLayoutAndPrecision) {
  constexpr std::size_t kSize = 37;
  std::vector<double> p = any_points(kSize, 10.0, 0.0, 1);
  std::vector<double> q = any_points(kSize, 10.0, 0.0, 2);
  for (double& x : p) x = double{static_cast<float>(x)};
  for (double& x : q) x = double{static_cast<float>(x)};
  const Correspondences interleaved(PointSpan<double>::interleaved(p.data(), kSize),
                                    PointSpan<double>::interleaved(q.data(), kSize));

  const auto planar = [](const std::vector<double>& points) {
    std::vector<double> rows(points.size());
    for (std::size_t i = 0; i < kSize; ++i) {
      for (std::size_t c = 0; c < 3; ++c) rows[c * kSize + i] = points[3 * i + c];
    }
    return rows;
  };
  const std::vector<double> p_planar = planar(p);
  const std::vector<double> q_planar = planar(q);
  expect_same(interleaved,
              {PointSpan<double>::planar(p_planar.data(), kSize), PointSpan<double>::planar(q_planar.data(), kSize)});

  const std::vector<float> p_float(p.begin(), p.end());
  const std::vector<float> q_float(q.begin(), q.end());
  expect_same(interleaved, {PointSpan<float>::interleaved(p_float.data(), kSize),
                            PointSpan<float>::interleaved(q_float.data(), kSize)});

  // x y z x' y' z' rows, the text file's layout, and the same read backwards
  std::vector<double> rows;
  for (std::size_t i = 0; i < kSize; ++i) {
    rows.insert(rows.end(), &p[3 * i], &p[3 * i] + 3);
    rows.insert(rows.end(), &q[3 * i], &q[3 * i] + 3);
  }
  expect_same(interleaved,
              {PointSpan<double>{rows.data(), kSize, 6, 1}, PointSpan<double>{rows.data() + 3, kSize, 6, 1}});
  const Correspondences backwards(PointSpan<double>{rows.data() + 6 * (kSize - 1), kSize, -6, 1},
                                  PointSpan<double>{rows.data() + 6 * (kSize - 1) + 3, kSize, -6, 1});
  EXPECT_FLOAT_EQ(backwards.view().source(0)[0], interleaved.view().source(0)[kSize - 1]);
}

TEST(Correspondences, AreCentredScaledAlignedAndPadded) {
  for (const std::size_t n : {1u, 2u, 3u, 63u, 64u, 65u, 1000u}) {
    const std::vector<double> p = any_points(n, 100.0, 5e6, 3);
    const std::vector<double> q = any_points(n, 100.0, -3e6, 4);
    const Correspondences c(PointSpan<double>::interleaved(p.data(), n), PointSpan<double>::interleaved(q.data(), n));
    const CorrespondenceView view = c.view();
    EXPECT_EQ(view.padded_size() % kBlock, 0u);
    EXPECT_LT(view.padded_size() - n, kBlock);
    EXPECT_EQ(view.words(), view.padded_size() / 64);
    EXPECT_EQ(std::exp2(std::round(std::log2(view.scale()))), view.scale());
    float largest = 0.0f;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(view.source(axis)) % 64, 0u);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(view.target(axis)) % 64, 0u);
      for (std::size_t i = 0; i < n; ++i) {
        largest = std::max({largest, std::abs(view.source(axis)[i]), std::abs(view.target(axis)[i])});
        EXPECT_NEAR(double{view.source(axis)[i]} / view.scale() + c.source_centroid()[axis], p[3 * i + axis], 1e-5);
        EXPECT_NEAR(double{view.target(axis)[i]} / view.scale() + c.target_centroid()[axis], q[3 * i + axis], 1e-5);
      }
      for (std::size_t i = n; i < view.padded_size(); ++i) {
        EXPECT_TRUE(std::isnan(view.source(axis)[i]) && std::isnan(view.target(axis)[i]));
      }
    }
    EXPECT_GE(largest, n == 1 ? 0.0f : 0.5f);
    EXPECT_LE(largest, 1.0f);
  }
}

TEST(Correspondences, MayBeEmptyOrAllEqual) {
  EXPECT_TRUE(Correspondences().empty());
  EXPECT_EQ(Correspondences().view().words(), 0u);
  const Correspondences none(PointSpan<double>{}, PointSpan<double>{});
  EXPECT_EQ(none.view().padded_size(), 0u);
  const std::vector<double> points(12, 7.5);
  const Correspondences equal(PointSpan<double>::interleaved(points.data(), 4),
                              PointSpan<double>::interleaved(points.data(), 4));
  EXPECT_EQ(equal.scale(), 1.0);
  EXPECT_EQ(equal.view().source(0)[3], 0.0f);
}

std::string message_of(const std::vector<double>& p, const std::vector<double>& q) {
  try {
    Correspondences(PointSpan<double>::interleaved(p.data(), p.size() / 3),
                    PointSpan<double>::interleaved(q.data(), q.size() / 3));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Correspondences, NameTheBadRow) {
  const std::vector<double> good = any_points(5, 1.0, 0.0, 5);
  std::vector<double> bad = good;
  bad[3 * 3 + 1] = std::nan("");
  EXPECT_EQ(message_of(good, bad), "target point 3: coordinate y is nan, expected a finite number");
  bad[3 * 3 + 1] = HUGE_VAL;
  EXPECT_EQ(message_of(bad, good), "source point 3: coordinate y is inf, expected a finite number");
  EXPECT_EQ(message_of(good, any_points(4, 1.0, 0.0, 5)),
            "correspondences need as many source as target points, got 5 and 4");
}

TEST(Correspondences, TakeAnyUnit) {
  for (const double magnitude : {1e-310, 1e-30, 1e-3, 1e3, 1e30, 1e300}) {
    const std::vector<double> p = any_points(20, magnitude, 0.0, 6);
    const Correspondences c(PointSpan<double>::interleaved(p.data(), 20), PointSpan<double>::interleaved(p.data(), 20));
    EXPECT_TRUE(std::isfinite(c.scale()));
    EXPECT_NEAR(double{c.view().source(0)[0]}, (p[0] - c.source_centroid()[0]) * c.scale(), 1e-7);
  }
  EXPECT_NE(message_of({1.7e308, 0, 0, -1.7e308, 0, 0, -1.7e308, 0, 0}, any_points(3, 1.0, 0.0, 1)), "");
}

TEST(Correspondences, GiveViewsOfPartOfTheRows) {
  constexpr std::size_t kSize = 150;
  const std::vector<double> p = any_points(kSize, 10.0, 0.0, 5);
  const Correspondences c(PointSpan<double>::interleaved(p.data(), kSize),
                          PointSpan<double>::interleaved(p.data(), kSize));
  const CorrespondenceView middle = c.view().rows(64, 64);
  EXPECT_EQ(middle.size(), 64u);
  EXPECT_EQ(middle.words(), 1u);
  EXPECT_EQ(middle.scale(), c.scale());
  const CorrespondenceView last = c.view().rows(64, 256);
  EXPECT_EQ(last.size(), kSize - 64);
  EXPECT_EQ(last.words(), 2u);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(middle.source(axis), c.view().source(axis) + 64);
    EXPECT_EQ(last.target(axis), c.view().target(axis) + 64);
  }
  // A part of a part keeps the distance between the arrays.
  EXPECT_EQ(last.rows(64, 64).target(2), c.view().target(2) + 128);
}

TEST(Correspondences, GiveSubsetsInTheSameFrame) {
  const std::vector<double> p = any_points(100, 10.0, 3.0, 7);
  const std::vector<double> q = any_points(100, 10.0, 3.0, 8);
  const Correspondences all(PointSpan<double>::interleaved(p.data(), 100),
                            PointSpan<double>::interleaved(q.data(), 100));
  const std::vector<std::uint32_t> rows{99, 0, 5, 5};
  const Correspondences some = all.subset(rows);
  ASSERT_EQ(some.size(), 4u);
  EXPECT_EQ(some.scale(), all.scale());
  EXPECT_EQ(some.source_centroid(), all.source_centroid());
  EXPECT_EQ(some.target_centroid(), all.target_centroid());
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(some.view().source(axis)[k], all.view().source(axis)[rows[k]]);
      EXPECT_EQ(some.view().target(axis)[k], all.view().target(axis)[rows[k]]);
    }
  }
  EXPECT_TRUE(std::isnan(some.view().source(0)[4]));
  EXPECT_TRUE(all.subset({}).empty());
  EXPECT_THROW((void)all.subset(std::vector<std::uint32_t>{100}), std::out_of_range);
}

TEST(Correspondences, KeepTheViewpointThatTheyAreTold) {
  const std::vector<double> p = any_points(10, 10.0, 3.0, 9);
  Correspondences all(PointSpan<double>::interleaved(p.data(), 10), PointSpan<double>::interleaved(p.data(), 10));
  EXPECT_EQ(all.source_viewpoint(), (std::array<double, 3>{}));
  const std::array<double, 3> viewpoint{4.0, -5e6, 0.25};
  all.set_source_viewpoint(viewpoint);
  EXPECT_EQ(all.source_viewpoint(), viewpoint);
  EXPECT_EQ(all.subset(std::vector<std::uint32_t>{7, 2, 1}).source_viewpoint(), viewpoint);
  EXPECT_EQ(all.with_scaled_source(2.0).source_viewpoint(), (std::array<double, 3>{8.0, -1e7, 0.5}));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(all.set_source_viewpoint({0.0, bad, 0.0}), std::invalid_argument);
  }
  EXPECT_EQ(all.source_viewpoint(), viewpoint);
}

TEST(Correspondences, CountOneNoValueOnceThoughMostRowsHaveIt) {
  constexpr std::size_t kRows = 20;
  for (const std::size_t without : {19U, 21U, 60U, 500U}) {
    for (const double value : {-9999.0, 65535.0, 1e10, 1e308}) {
      for (const bool both : {false, true}) {
        std::vector<double> p = any_points(kRows + without, 3.0, 1.0, 4);
        std::vector<double> q = any_points(kRows + without, 3.0, -2.0, 5);
        std::fill(p.begin() + 3 * kRows, p.end(), value);
        if (both) std::fill(q.begin() + 3 * kRows, q.end(), value);
        const Correspondences all(PointSpan<double>::interleaved(p.data(), kRows + without),
                                  PointSpan<double>::interleaved(q.data(), kRows + without));
        const std::vector<std::uint32_t> far(all.far_rows().begin(), all.far_rows().end());
        ASSERT_EQ(far.size(), without) << value;
        EXPECT_EQ(far.front(), kRows);
        EXPECT_LE(1.0 / all.scale(), 8.0);
        EXPECT_LT(all.resolution(), 1e-5);
      }
    }
  }
  // A row that is repeated most and lies among the others is one of them.
  std::vector<double> p = any_points(100, 3.0, 1.0, 6);
  for (std::size_t k = 40; k < 99; ++k) std::copy_n(p.begin(), 3, p.begin() + static_cast<std::ptrdiff_t>(3 * k));
  std::fill(p.end() - 3, p.end(), 1e6);
  const Correspondences board(PointSpan<double>::interleaved(p.data(), 100),
                              PointSpan<double>::interleaved(p.data(), 100));
  ASSERT_EQ(board.far_rows().size(), 1U);
  EXPECT_EQ(board.far_rows().front(), 99U);
}

TEST(Correspondences, CountSeveralNoValuesOnceEach) {
  constexpr std::size_t kRows = 20;
  constexpr std::array kValues{-9999.0, 65535.0, -32768.0, 1e38, 9999.0, 1e10};
  for (std::size_t values = 2; values <= kValues.size(); ++values) {
    for (const std::size_t each : {12U, 20U, 60U}) {
      const std::size_t without = values * each;
      // Each value stands in the sources, in the targets or in both.
      std::vector<double> p = any_points(kRows + without, 3.0, 1.0, 8);
      std::vector<double> q = any_points(kRows + without, 3.0, -2.0, 9);
      for (std::size_t k = 0; k < without; ++k) {
        const std::size_t value = k / each;
        const auto at = static_cast<std::ptrdiff_t>(3 * (kRows + k));
        if (value % 3 != 1) std::fill_n(p.begin() + at, 3, kValues[value]);
        if (value % 3 != 0) std::fill_n(q.begin() + at, 3, kValues[value]);
      }
      const Correspondences all(PointSpan<double>::interleaved(p.data(), kRows + without),
                                PointSpan<double>::interleaved(q.data(), kRows + without));
      ASSERT_EQ(all.far_rows().size(), without) << values << " values in " << each << " rows each";
      EXPECT_EQ(all.far_rows().front(), kRows);
      EXPECT_LE(1.0 / all.scale(), 8.0);
    }
  }
}

TEST(Correspondences, TheTargetsOfABoardAreTheBulkBesideFewerFarRows) {
  constexpr std::size_t kFrames = 50;
  for (const std::size_t targets : {4U, 5U, 35U}) {
    const std::vector<double> board = any_points(targets, 3.0, 1.0, 10);
    std::vector<double> p;
    for (std::size_t frame = 0; frame < kFrames; ++frame) p.insert(p.end(), board.begin(), board.end());
    const std::size_t far = targets * kFrames / 2;
    std::vector<double> q = p;
    for (const double value : any_points(far, 10.0, 1e6, 11)) p.push_back(value);
    for (const double value : any_points(far, 10.0, 1e6, 12)) q.push_back(value);
    const std::size_t rows = targets * kFrames + far;
    const Correspondences all(PointSpan<double>::interleaved(p.data(), rows),
                              PointSpan<double>::interleaved(q.data(), rows));
    ASSERT_EQ(all.far_rows().size(), far) << targets;
    EXPECT_EQ(all.far_rows().front(), targets * kFrames);
  }
}

// Most rows may tell of nothing: the frame is that of those that keep their distances.
class RowsElsewhere : public ::testing::TestWithParam<std::size_t> {
 protected:
  static constexpr std::size_t kRows = 30;

  // Twenty rows that keep their distances and ten others, and then as many as wanted.
  RowsElsewhere() : p_(any_points(kRows + GetParam(), 3.0, 1.0, 13)), q_(p_) {
    const std::vector<double> other = any_points(kRows + GetParam(), 3.0, 1.0, 14);
    std::copy(other.begin() + 60, other.end(), q_.begin() + 60);
  }
  [[nodiscard]] Correspondences correspondences() const {
    return {PointSpan<double>::interleaved(p_.data(), p_.size() / 3),
            PointSpan<double>::interleaved(q_.data(), q_.size() / 3)};
  }
  // All further rows.
  void for_each_coordinate(const auto& change) {
    for (std::size_t k = 3 * kRows; k < p_.size(); ++k) change(k);
  }

  std::vector<double> p_;
  std::vector<double> q_;
};
INSTANTIATE_TEST_SUITE_P(Numbers, RowsElsewhere, ::testing::Values(29, 31, 60, 120));

TEST_P(RowsElsewhere, MakeTheFrameBesideOnePlaceALittleElsewhereInEachRow) {
  for_each_coordinate([&](std::size_t k) {
    p_[k] = p_[k % 3] + 1e-4 * p_[k];
    q_[k] = q_[60 + k % 3] + 1e-4 * q_[k];
  });
  EXPECT_TRUE(correspondences().far_rows().empty());
}

TEST_P(RowsElsewhere, MakeTheFrameBesideOneFarPlace) {
  for_each_coordinate([&](std::size_t k) { p_[k] = 1e6 + 1e-4 * p_[k]; });
  const Correspondences all = correspondences();
  ASSERT_EQ(all.far_rows().size(), GetParam());
  EXPECT_EQ(all.far_rows().front(), kRows);
}

TEST_P(RowsElsewhere, MakeTheFrameWhereACoordinateIsLost) {
  for_each_coordinate([&](std::size_t k) {
    if (k % 3 == 2) q_[k] = -9999.0;
  });
  EXPECT_EQ(correspondences().far_rows().size(), GetParam());
}

TEST_P(RowsElsewhere, MakeTheFrameBesideCopiesOfFarRows) {
  constexpr std::size_t kFar = 15;
  if (GetParam() > 3 * kFar) GTEST_SKIP() << "more copies than look like anything but the bulk";
  for_each_coordinate([&](std::size_t k) {
    const std::size_t first = 3 * kRows + k % (3 * kFar);
    p_[k] = k == first ? 1e6 * p_[k] : p_[first];
    q_[k] = k == first ? 1e6 * q_[k] : q_[first];
  });
  EXPECT_EQ(correspondences().far_rows().size(), GetParam());
}

}  // namespace
}  // namespace consimd::test
