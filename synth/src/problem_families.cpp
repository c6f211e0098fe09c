#include <consimd/synth/problem_families.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include <consimd/synth/field_problems.hpp>
#include <consimd/synth/hard_problems.hpp>

namespace consimd::synth {
namespace {

// What a declaration below needs to know of a problem's rows.
std::size_t inliers_of(const HardProblemOptions& o) {
  return static_cast<std::size_t>(std::floor(static_cast<double>(o.correspondences) * (1.0 - o.outlier_ratio) + 0.5));
}
std::size_t outliers_of(const HardProblemOptions& o) { return o.correspondences - inliers_of(o); }

/// The options with so many outliers less.
HardProblemOptions with_fewer_outliers(HardProblemOptions o, std::size_t less) {
  const auto inliers = static_cast<double>(inliers_of(o));
  o.correspondences -= less;
  o.outlier_ratio = 1.0 - inliers / static_cast<double>(o.correspondences);
  return o;
}

/// A tenth of the outliers, which a family replaces; a row is left.
std::size_t tenth_of_outliers(const HardProblemOptions& o) {
  return std::min(outliers_of(o) / 10, o.correspondences - 1);
}

Problem far_rows(const HardProblemOptions& o) {
  const std::size_t rows = tenth_of_outliers(o);
  return with_far_rows(hard_problem(with_fewer_outliers(o, rows)),
                       {.rows = rows, .distance = 1e4 * o.half_extent, .seed = o.seed, .trial = o.trial});
}

Problem rows_without_depth(const HardProblemOptions& o) {
  const std::size_t rows = tenth_of_outliers(o);
  return with_rows_without_depth(hard_problem(with_fewer_outliers(o, rows)), rows, o.seed, o.trial);
}

struct Declaration {
  ProblemFamily family;
  Problem (*make)(HardProblemOptions paper);
};

/// A family with other outliers, in a scene that has look-alikes of the kind.
template <Scene kScene, OutlierModel kOutliers>
Problem with(HardProblemOptions o) {
  o.scene = kScene;
  // One outlier has no other to be permuted with.
  o.outliers = kOutliers == OutlierModel::permuted && outliers_of(o) == 1 ? OutlierModel::uniform : kOutliers;
  return hard_problem(o);
}

template <NoiseModel kNoise>
Problem with_noise(HardProblemOptions o) {
  o.noise = kNoise;
  return hard_problem(o);
}

constexpr std::array kDeclarations{
    Declaration{{"gaussian",
                 "The paper's: points in a cube, outliers uniform in it, Gaussian noise, the same everywhere", true},
                &with<Scene::volume, OutlierModel::uniform>},

    Declaration{
        {"heavy_tails", "Noise of a Student t with three degrees of freedom: most is small, a little is large", false},
        &with_noise<NoiseModel::student_t>},
    Declaration{{"range_dependent", "Gaussian noise whose deviation grows with the distance from the sensor", false},
                &with_noise<NoiseModel::range_dependent>},
    Declaration{
        {"anisotropic",
         "Gaussian noise, five times as much along the ray from the sensor as across, as of stereo cameras", false},
        &with_noise<NoiseModel::anisotropic>},
    Declaration{{"quantised", "All coordinates rounded to multiples of 2 sigma, on top of Gaussian noise", false},
                [](HardProblemOptions o) {
                  o.quantum = 2.0 * o.sigma;
                  return hard_problem(o);
                }},

    Declaration{{"permuted", "Outliers are true points, associated at random: both clouds have the true shape", true},
                &with<Scene::volume, OutlierModel::permuted>},
    Declaration{
        {"clustered", "Outliers join ten pairs of dense clusters: many of them nearly agree with each other", true},
        &with<Scene::volume, OutlierModel::clustered>},
    Declaration{{"one_to_many", "Three outliers share a source point, as without a cross-check of matches", true},
                &with<Scene::volume, OutlierModel::one_to_many>},
    Declaration{{"many_to_many", "Wrong pairs among the features of the true ones, as of mutual top-3 matching", true},
                &with<Scene::volume, OutlierModel::many_to_many>},
    Declaration{{"decoy", "Outliers, half as many as inliers where there are, follow a second rigid motion", true},
                [](HardProblemOptions o) {
                  const auto inliers = static_cast<double>(inliers_of(o));
                  if (inliers > 0.0) o.decoy_share = std::min(0.5, static_cast<double>(outliers_of(o)) / inliers);
                  return hard_problem(o);
                }},
    Declaration{{"kept_range", "Outliers keep their distance from the sensor, as descriptors with range do", true},
                &with<Scene::volume, OutlierModel::alike>},
    Declaration{{"kept_ring", "Circles of a spinning scanner on flat ground; outliers keep the circle", true},
                &with<Scene::rings, OutlierModel::alike>},
    Declaration{{"kept_height", "Poles and trunks on flat ground; outliers keep the height on any pole", true},
                &with<Scene::poles, OutlierModel::alike>},
    Declaration{
        {"repeated_structure", "A front of equal windows; outliers join the same corners of different ones", true},
        &with<Scene::facade, OutlierModel::alike>},
    Declaration{{"lattice", "Nodes of a cubic lattice; outliers join any two", true},
                &with<Scene::grid, OutlierModel::alike>},
    Declaration{
        {"symmetric", "A scene that a half turn maps to itself; outliers as many as half the inliers follow it", true},
        [](HardProblemOptions o) {
          const auto inliers = static_cast<double>(inliers_of(o));
          if (inliers > 0.0) o.decoy_share = std::min(0.5, static_cast<double>(outliers_of(o)) / inliers);
          o.symmetric = true;
          return hard_problem(o);
        }},

    Declaration{{"planar", "All points in a slab 0.1 m thick; outliers' targets uniform in the cube", true},
                &with<Scene::planar, OutlierModel::uniform>},
    Declaration{
        {"linear",
         "All points in a rod 0.1 m thick, about which the turn can hardly be told; outliers' targets uniform", true},
        &with<Scene::linear, OutlierModel::uniform>},
    Declaration{{"street", "Ground and two rows of houses; outliers keep their place in the cross-section", true},
                &with<Scene::street, OutlierModel::alike>},
    Declaration{{"indoor", "Walls, floor and ceiling of a room; outliers keep the wall", true},
                &with<Scene::room, OutlierModel::alike>},

    Declaration{{"copies", "A tenth of the rows are copies of others", true},
                [](HardProblemOptions o) {
                  o.duplicates = std::min(o.correspondences / 10, o.correspondences - 1);
                  o.correspondences -= o.duplicates;
                  return hard_problem(o);
                }},
    Declaration{{"far_rows", "A tenth of the outliers lie up to ten thousand times as far away as all else", true},
                [](HardProblemOptions o) { return far_rows(o); }},
    Declaration{{"no_depth", "A tenth of the outliers are rows of zeros, as pixels without depth give", true},
                [](HardProblemOptions o) { return rows_without_depth(o); }},
};

constexpr auto kFamilies = [] {
  std::array<ProblemFamily, kDeclarations.size()> families{};
  for (std::size_t k = 0; k < families.size(); ++k) families[k] = kDeclarations[k].family;
  return families;
}();

const Declaration& declaration(std::string_view name) {
  std::string known;
  for (const Declaration& one : kDeclarations) {
    if (one.family.name == name) return one;
    known.append(known.empty() ? "" : ", ").append(one.family.name);
  }
  throw std::invalid_argument("family '" + std::string(name) + "': expected one of: " + known);
}

}  // namespace

std::span<const ProblemFamily> problem_families() noexcept { return kFamilies; }

const ProblemFamily& problem_family(std::string_view name) {
  return kFamilies[static_cast<std::size_t>(&declaration(name) - kDeclarations.data())];
}

Problem family_problem(std::string_view family, const NoiseStudyOptions& options) {
  const Declaration& declared = declaration(family);
  // What is out of range, `hard_problem` says; before, a family computes with it.
  const HardProblemOptions paper{.correspondences = options.correspondences,
                                 .outlier_ratio = options.outlier_ratio,
                                 .sigma = options.sigma,
                                 .half_extent = options.half_extent,
                                 .seed = options.seed,
                                 .trial = options.trial,
                                 .scale = options.scale};
  const bool in_range = paper.outlier_ratio >= 0.0 && paper.outlier_ratio <= 1.0 && paper.correspondences >= 1;
  return in_range ? declared.make(paper) : hard_problem(paper);
}

}  // namespace consimd::synth
