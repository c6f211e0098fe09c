#include <consimd/studies/registration_picture.hpp>

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <consimd/solvers/solver.hpp>
#include <consimd/synth/noise_study.hpp>

#include "files/json_text.hpp"
#include "pictures/page_text.hpp"

namespace consimd::studies {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

/// The points of a wavy floor.
Cloud floor_of(std::size_t points, double x, std::uint32_t seed = 1) {
  std::mt19937 draw(seed);
  std::vector<double> values;
  for (std::size_t i = 0; i < points; ++i) {
    const double u = 20.0 * (static_cast<double>(draw()) / 0x1p32), v = 20.0 * (static_cast<double>(draw()) / 0x1p32);
    values.insert(values.end(), {x + u, v, std::sin(u) + std::cos(v)});
  }
  return Cloud(PointSpan<double>::interleaved(values.data(), points));
}

struct Registered {
  synth::Problem problem =
      synth::noise_study_problem({.correspondences = 500, .outlier_ratio = 0.6, .sigma = 0.1, .seed = 3});
  Correspondences rows = problem.correspondences();
  Registration run = register_by_name("tcf", rows, {.noise_bound = 0.3});

  [[nodiscard]] RegistrationPicture picture() const {
    return {.correspondences = &rows, .registration = &run, .source_name = "a pair.txt", .solver = "tcf"};
  }
};

/// What the page's script reads.
Json data_of(const std::string& page) {
  constexpr std::string_view kOpening = R"(<script type="application/json" id="data">)";
  const std::size_t begin = page.find(kOpening) + kOpening.size();
  return parse_json(std::string_view(page).substr(begin, page.find("</script>", begin) - begin));
}

std::vector<float> decoded(std::string_view text) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    word = word << 6U | static_cast<std::uint32_t>(kDigits.find(c));
    bits += 6;
    if (bits >= 8) bytes.push_back(static_cast<std::uint8_t>(word >> (bits -= 8)));
  }
  std::vector<float> numbers;
  for (std::size_t i = 0; i + 4 <= bytes.size(); i += 4) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4; ++k) value |= std::uint32_t{bytes[i + k]} << (8 * k);
    numbers.push_back(std::bit_cast<float>(value));
  }
  return numbers;
}

Eigen::Vector3d three(const Json& numbers) {
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

Eigen::Vector3d point(const std::vector<float>& numbers, std::size_t first) {
  return Eigen::Vector3f(numbers[first], numbers[first + 1], numbers[first + 2]).cast<double>();
}

Eigen::Affine3d placement(const Json& data, std::size_t index) {
  const auto numbers = data["placements"][index]["matrix"].get<std::vector<double>>();
  return Eigen::Affine3d(Eigen::Map<const Eigen::Matrix4d>(numbers.data()));
}

TEST(RegistrationPage, NeedsNothingButItself) {
  const Registered pair;
  const std::string page = registration_page(pair.picture());
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page, Not(HasSubstr("http:")));
  EXPECT_THAT(page, Not(HasSubstr("https:")));
  EXPECT_THAT(page, Not(HasSubstr(" src=")));
  EXPECT_THAT(page, Not(HasSubstr("{{")));
  EXPECT_THAT(page, Not(HasSubstr("url(")));
}

TEST(RegistrationPage, TellsWhatWasFound) {
  const Registered pair;
  ASSERT_EQ(pair.run.status, Status::success);
  const std::string page = registration_page(pair.picture());
  EXPECT_THAT(page, HasSubstr("<title>a pair.txt</title>"));
  EXPECT_THAT(page, HasSubstr(R"(<span class="status success">success</span>)"));
  EXPECT_THAT(page, HasSubstr("<tr><th>correspondences</th><td>500</td></tr>"));
  EXPECT_THAT(page, HasSubstr("<tr><th>noise bound</th><td>0.3</td></tr>"));
  EXPECT_THAT(page, HasSubstr("<td>" + std::to_string(pair.run.inliers.size()) + " ("));
  EXPECT_THAT(page, HasSubstr("<caption>T_target_source</caption>"));
  EXPECT_EQ(page, registration_page(pair.picture()));
}

TEST(RegistrationPage, ArraysAreTheCorrespondences) {
  const Registered pair;
  const Json data = data_of(registration_page(pair.picture()));
  EXPECT_TRUE(data["pose"].get<bool>());
  ASSERT_EQ(data["placements"].size(), 2u);
  EXPECT_EQ(data["placements"][0]["name"], "before");
  EXPECT_EQ(data["placements"][1]["name"], "after");
  EXPECT_EQ(data["inliers"]["size"], pair.run.inliers.size());
  EXPECT_EQ(data["outliers"]["size"], 500 - pair.run.inliers.size());
  const Eigen::Vector3d source_origin = three(data["source"]["origin"]),
                        target_origin = three(data["target"]["origin"]);

  // Every drawn line is a row of the problem, each once, and its ends are where the placements put them.
  std::vector<bool> seen(pair.problem.size());
  for (const char* const kind : {"inliers", "outliers"}) {
    const std::vector<float> lines = decoded(data[kind]["lines"].get<std::string>());
    ASSERT_EQ(lines.size(), 6 * data[kind]["size"].get<std::size_t>());
    for (std::size_t at = 0; at < lines.size(); at += 6) {
      const Eigen::Vector3d p = point(lines, at), q = point(lines, at + 3);
      std::size_t row = 0;
      while (row < pair.problem.size()) {
        const Eigen::Map<const Eigen::Vector3d> source(pair.problem.source.data() + 3 * row);
        if ((p + source_origin - source).norm() < 1e-4) break;
        ++row;
      }
      ASSERT_LT(row, pair.problem.size());
      EXPECT_FALSE(seen[row]);
      seen[row] = true;
      const Eigen::Map<const Eigen::Vector3d> source(pair.problem.source.data() + 3 * row);
      const Eigen::Map<const Eigen::Vector3d> target(pair.problem.target.data() + 3 * row);
      EXPECT_LT((q + target_origin - target).norm(), 1e-4);
      EXPECT_LT((placement(data, 0) * p + target_origin - source).norm(), 1e-4);
      EXPECT_LT((placement(data, 1) * p + target_origin - pair.run.T_target_source * source).norm(), 1e-4);
      const double residual = (placement(data, 1) * p - q).norm();
      EXPECT_EQ(residual < 0.3, std::string_view(kind) == "inliers") << row << ' ' << residual;
    }
  }
}

TEST(RegistrationPage, MapCoordinatesLoseNothing) {
  const Cloud source = floor_of(300, 0.0), target = floor_of(300, 5e6);
  const Correspondences none;
  const Registration run;
  const std::string page = registration_page(
      {.correspondences = &none, .registration = &run, .source = &source, .target = &target, .source_name = "a"});
  const Json data = data_of(page);
  const std::vector<float> numbers = decoded(data["target"]["points"].get<std::string>());
  ASSERT_EQ(numbers.size(), 900u);
  for (std::size_t i = 0; i < 300; ++i) {
    const auto at = target.point(i);
    EXPECT_LT((point(numbers, 3 * i) + three(data["target"]["origin"]) - Eigen::Vector3d(at[0], at[1], at[2])).norm(),
              1e-5);
  }
  // Both would be specks as they lie: the page shows them side by side and says so.
  EXPECT_THAT(page, HasSubstr("before: the source is drawn"));
  EXPECT_LT(placement(data, 0).translation().norm(), 100.0);
}

TEST(RegistrationPage, LargeCloudsAreThinnedOut) {
  const Cloud source = floor_of(1'000'000, 0.0), target = floor_of(1000, 1.0);
  const Correspondences none;
  const Registration run;
  const RegistrationPicture picture{
      .correspondences = &none, .registration = &run, .source = &source, .target = &target, .source_name = "a"};
  tbb::task_arena one(1), two(2);
  const std::string page = one.execute([&] { return registration_page(picture); });
  EXPECT_EQ(page, two.execute([&] { return registration_page(picture); }));
  const Json data = data_of(page);
  const std::size_t drawn = decoded(data["source"]["points"].get<std::string>()).size() / 3;
  EXPECT_LE(drawn, 200'000u);
  EXPECT_GE(drawn, 100'000u);
  EXPECT_EQ(data["source"]["size"], 1'000'000u);
  EXPECT_THAT(page, HasSubstr("<li>source: " + grouped(drawn) + " points drawn, the means of voxels of "));
  EXPECT_THAT(page, Not(HasSubstr("<li>target")));
}

TEST(RegistrationPage, WithoutPoseThereIsOnlyBefore) {
  Registered pair;
  pair.run = Registration{};
  const std::string page = registration_page(pair.picture());
  EXPECT_THAT(page, HasSubstr(R"(<span class="status no_consensus">no_consensus</span>)"));
  EXPECT_THAT(page, HasSubstr("no pose: none has more support than chance gives"));
  EXPECT_THAT(page, Not(HasSubstr("<caption>T_target_source")));
  const Json data = data_of(page);
  EXPECT_FALSE(data["pose"].get<bool>());
  EXPECT_EQ(data["placements"].size(), 1u);
  EXPECT_EQ(data["inliers"]["size"], 0);
  EXPECT_EQ(data["outliers"]["size"], 500);
}

TEST(RegistrationPage, ShowsTheRunnerUp) {
  Registered pair;
  pair.run.runner_up = RunnerUp{.T_target_source = RigidTransform(Eigen::Translation3d(1.0, 2.0, 3.0)), .support = 77};
  const std::string page = registration_page(pair.picture());
  EXPECT_THAT(page, HasSubstr("<tr><th>runner-up</th><td>77 inliers</td></tr>"));
  const Json data = data_of(page);
  ASSERT_EQ(data["placements"].size(), 3u);
  EXPECT_EQ(data["placements"][2]["name"], "runner-up");
  const Eigen::Vector3d shift = three(data["source"]["origin"]) - three(data["target"]["origin"]);
  EXPECT_LT((placement(data, 2).translation() - shift - Eigen::Vector3d(1.0, 2.0, 3.0)).norm(), 1e-9);
}

TEST(RegistrationPage, TheScaleIsPartOfThePlacement) {
  Registered pair;
  pair.run.scale = 2.0;
  const Json data = data_of(registration_page(pair.picture()));
  EXPECT_NEAR(placement(data, 1).linear().determinant(), 8.0, 1e-9);
}

TEST(RegistrationPage, NamesCannotBecomeMarkup) {
  const Registered pair;
  RegistrationPicture picture = pair.picture();
  picture.source_name = "</script><img onerror='x' src=\"y\">\xff\x01";
  picture.target_name = "{{data}}&amp;";
  picture.solver = "<b>";
  for (const std::string& text : {registration_page(picture), registration_svg(picture)}) {
    EXPECT_THAT(text, Not(HasSubstr("<img")));
    EXPECT_THAT(text, Not(HasSubstr("<b>")));
    EXPECT_THAT(text, Not(HasSubstr("\xff")));
    EXPECT_THAT(text, Not(HasSubstr("\x01")));
    EXPECT_THAT(text, HasSubstr("&lt;img onerror=&#39;x&#39; src=&quot;y&quot;&gt;"));
    EXPECT_THAT(text, HasSubstr("{{data}}&amp;amp;"));
  }
}

TEST(RegistrationPicture, WhatCannotBeDrawnIsNamed) {
  const Registered pair;
  const Cloud cloud = floor_of(10, 0.0), empty;
  RegistrationPicture picture = pair.picture();
  const auto draw = [&picture] { return registration_page(picture); };
  picture.source = &cloud;
  EXPECT_THAT(draw, ThrowsMessage<std::invalid_argument>(HasSubstr("both clouds, or none")));
  picture.target = &empty;
  EXPECT_THAT(draw, ThrowsMessage<std::invalid_argument>(HasSubstr("the target cloud of the picture is empty")));
  picture = pair.picture();
  Registration other = pair.run;
  other.inliers = {500};
  picture.registration = &other;
  EXPECT_THAT(draw, ThrowsMessage<std::invalid_argument>(HasSubstr("inlier 500 is none of the picture's 500")));
  picture.registration = nullptr;
  EXPECT_THAT(draw, ThrowsMessage<std::invalid_argument>(HasSubstr("needs correspondences and their registration")));
}

TEST(RegistrationSvg, DrawsBeforeBesideAfter) {
  const Registered pair;
  const std::string svg = registration_svg(pair.picture());
  EXPECT_THAT(svg, HasSubstr(R"(viewBox="0 0 960 474")"));
  EXPECT_THAT(svg, HasSubstr(">before</text>"));
  EXPECT_THAT(svg, HasSubstr(">after</text>"));
  EXPECT_THAT(svg, HasSubstr("success: a pose with significant support; noise bound 0.3"));
  EXPECT_THAT(svg, HasSubstr(std::to_string(pair.run.inliers.size()) + " inliers"));
  // Points of both clouds in both panels, nearly all of them: the frame leaves out the farthest few.
  std::size_t drawn = 0;
  for (std::size_t at = svg.find("h0"); at != std::string::npos; at = svg.find("h0", at + 2)) ++drawn;
  EXPECT_GT(drawn, 1800);
  EXPECT_LE(drawn, 2000);
  EXPECT_EQ(svg, registration_svg(pair.picture()));
}

TEST(RegistrationSvg, WithoutPoseThereIsOnePanel) {
  Registered pair;
  pair.run = Registration{};
  const std::string svg = registration_svg(pair.picture());
  EXPECT_THAT(svg, HasSubstr(R"(viewBox="0 0 480 474")"));
  EXPECT_THAT(svg, HasSubstr(">as given</text>"));
  EXPECT_THAT(svg, HasSubstr("500 correspondences"));
  EXPECT_THAT(svg, Not(HasSubstr("outliers")));
}

TEST(PageText, Base64IsThatOfRfc4648) {
  const auto encoded = [](std::string_view text) { return base64(std::as_bytes(std::span(text))); };
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foob"), "Zm9vYg==");
  EXPECT_EQ(encoded("fooba"), "Zm9vYmE=");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
}

TEST(PageText, ThousandsAreGrouped) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1'234'567),
            "1\xe2\x80\xaf"
            "234\xe2\x80\xaf"
            "567");
}

}  // namespace
}  // namespace consimd::studies
