// Synthetic problems.
#include <consimd/synth/problem.hpp>

#include <array>
#include <string>
#include <string_view>

#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>
#include <consimd/synth/problem_families.hpp>
#include <consimd/synth/problem_files.hpp>
#include <consimd/synth/stand_ins.hpp>

#include "array_arguments.hpp"
#include "array_results.hpp"
#include "bindings.hpp"
#include "named_values.hpp"

namespace consimd::python {

template <>
struct NamedValues<synth::Scene> {
  static constexpr std::array kValues{Named{"volume", synth::Scene::volume},     Named{"planar", synth::Scene::planar},
                                      Named{"linear", synth::Scene::linear},     Named{"rings", synth::Scene::rings},
                                      Named{"poles", synth::Scene::poles},       Named{"lines", synth::Scene::lines},
                                      Named{"corridor", synth::Scene::corridor}, Named{"room", synth::Scene::room},
                                      Named{"street", synth::Scene::street},     Named{"facade", synth::Scene::facade},
                                      Named{"grid", synth::Scene::grid}};
};

template <>
struct NamedValues<synth::OutlierModel> {
  static constexpr std::array kValues{
      Named{"uniform", synth::OutlierModel::uniform},           Named{"permuted", synth::OutlierModel::permuted},
      Named{"clustered", synth::OutlierModel::clustered},       Named{"one_to_many", synth::OutlierModel::one_to_many},
      Named{"many_to_many", synth::OutlierModel::many_to_many}, Named{"alike", synth::OutlierModel::alike}};
};

template <>
struct NamedValues<synth::NoiseModel> {
  static constexpr std::array kValues{
      Named{"gaussian", synth::NoiseModel::gaussian}, Named{"range_dependent", synth::NoiseModel::range_dependent},
      Named{"student_t", synth::NoiseModel::student_t}, Named{"anisotropic", synth::NoiseModel::anisotropic}};
};

namespace {

using synth::HardProblemOptions;
using synth::Problem;

Problem noise_study(std::size_t correspondences, double outlier_ratio, double sigma, double half_extent,
                    std::uint64_t seed, std::uint64_t trial) {
  const nb::gil_scoped_release unlocked;
  return synth::noise_study_problem({correspondences, outlier_ratio, sigma, half_extent, seed, trial});
}

Problem of_family(std::string_view family, std::size_t correspondences, double outlier_ratio, double sigma,
                  double half_extent, std::uint64_t seed, std::uint64_t trial) {
  const nb::gil_scoped_release unlocked;
  return synth::family_problem(family, {correspondences, outlier_ratio, sigma, half_extent, seed, trial});
}

Problem hard(std::size_t correspondences, double outlier_ratio, double sigma, double half_extent, std::uint64_t seed,
             std::uint64_t trial, std::string_view scene, double thickness, std::size_t parts,
             std::string_view outliers, std::size_t clusters, double cluster_sigma, std::size_t matches_per_point,
             double decoy_share, bool symmetric, std::string_view noise, unsigned degrees_of_freedom, double anisotropy,
             std::size_t duplicates, bool mirrored, double quantum, std::array<double, 3> source_offset,
             std::array<double, 3> target_offset, double units_per_metre) {
  const HardProblemOptions options{.correspondences = correspondences,
                                   .outlier_ratio = outlier_ratio,
                                   .sigma = sigma,
                                   .half_extent = half_extent,
                                   .seed = seed,
                                   .trial = trial,
                                   .scene = value_named<synth::Scene>(scene, "scene"),
                                   .thickness = thickness,
                                   .parts = parts,
                                   .outliers = value_named<synth::OutlierModel>(outliers, "outliers"),
                                   .clusters = clusters,
                                   .cluster_sigma = cluster_sigma,
                                   .matches_per_point = matches_per_point,
                                   .decoy_share = decoy_share,
                                   .symmetric = symmetric,
                                   .noise = value_named<synth::NoiseModel>(noise, "noise"),
                                   .degrees_of_freedom = degrees_of_freedom,
                                   .anisotropy = anisotropy,
                                   .duplicates = duplicates,
                                   .mirrored = mirrored,
                                   .quantum = quantum,
                                   .source_offset = source_offset,
                                   .target_offset = target_offset,
                                   .units_per_metre = units_per_metre};
  const nb::gil_scoped_release unlocked;
  return synth::hard_problem(options);
}

Problem stand_in(std::string_view name, std::uint64_t seed, std::uint64_t trial) {
  const nb::gil_scoped_release unlocked;
  return synth::stand_in_problem(synth::stand_in(name), seed, trial);
}

nb::dict describe(const synth::StandIn& stand_in) {
  nb::dict facts;
  facts["dataset"] = stand_in.dataset;
  facts["sequence"] = stand_in.sequence;
  facts["pair_distance"] = stand_in.pair_distance;
  facts["correspondences"] = stand_in.correspondences;
  facts["inlier_ratio"] = stand_in.inlier_ratio;
  facts["inlier_distance"] = stand_in.inlier_distance;
  facts["noise_bound"] = stand_in.noise_bound;
  return facts;
}

std::vector<double> doubles_from(ArrayLike points_like, std::string_view name) {
  Points points(points_like, name);
  points.widen();
  const auto span = points.span<double>();
  std::vector<double> values(3 * span.size);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = span(k / 3, k % 3);
  return values;
}

void make_problem(Problem* self, ArrayLike source, ArrayLike target, ArrayLike is_inlier, ArrayLike pose,
                  double sigma) {
  Problem problem;
  problem.source = doubles_from(source, "source");
  problem.target = doubles_from(target, "target");
  if (problem.source.size() != problem.target.size()) {
    throw nb::value_error(("source has " + std::to_string(problem.source.size() / 3) + " points, target " +
                           std::to_string(problem.target.size() / 3))
                              .c_str());
  }
  problem.is_inlier = mask_from(is_inlier, "is_inlier", problem.source.size() / 3);
  problem.T_target_source = transform_from(pose, "pose");
  problem.sigma = sigma;
  new (self) Problem(std::move(problem));
}

View<double, -1, 3> points_view(const std::vector<double>& points, nb::handle owner) {
  return View<double, -1, 3>(points.data(), {points.size() / 3, 3}, owner);
}

const Problem& problem_of(nb::handle self) { return nb::cast<const Problem&>(self); }

void bind_problem(nb::module_& module) {
  nb::class_<Problem>(module, "Problem",
                      "N putative correspondences and the truth about them. Lengths in one unit, metres unless said\n"
                      "otherwise.")
      .def("__init__", &make_problem, nb::arg("source"), nb::arg("target"), nb::arg("is_inlier"), nb::arg("pose"),
           nb::arg("sigma") = 0.0,
           "Of your own data. source, target: (N, 3); is_inlier: (N,) truth values; pose: (4, 4), source to target;\n"
           "sigma: standard deviation of an inlier's noise, per axis.")
      .def_prop_ro(
          "source", [](nb::handle self) { return points_view(problem_of(self).source, self); },
          "(N, 3) float64, a read-only view")
      .def_prop_ro(
          "target", [](nb::handle self) { return points_view(problem_of(self).target, self); },
          "(N, 3) float64, a read-only view")
      .def_prop_ro(
          "is_inlier",
          [](nb::handle self) {
            const std::vector<std::uint8_t>& labels = problem_of(self).is_inlier;
            static_assert(sizeof(bool) == sizeof(std::uint8_t));
            return View<bool, -1>(labels.data(), {labels.size()}, self);
          },
          "(N,) bool, a read-only view: the rows that the true motion made")
      .def_prop_ro(
          "pose", [](const Problem& problem) { return to_array(problem.T_target_source); }, nb::rv_policy::automatic,
          "(4, 4) float64, the true motion T_target_source")
      .def_prop_ro(
          "decoy_pose", [](const Problem& problem) { return to_array(problem.decoy_T_target_source); },
          nb::rv_policy::automatic, "(4, 4) float64, what decoys follow, where there are any")
      .def_ro("sigma", &Problem::sigma, "Standard deviation of an inlier's noise, per axis")
      .def("__len__", &Problem::size)
      .def("__repr__",
           [](const Problem& problem) {
             std::size_t inliers = 0;
             for (const std::uint8_t label : problem.is_inlier) inliers += label;
             return "<consimd.synth.Problem: " + std::to_string(problem.size()) + " correspondences, " +
                    std::to_string(inliers) + " true>";
           })
      .def(
          "correspondences",
          [](const Problem& problem) {
            return SharedCorrespondences{std::make_shared<const Correspondences>(problem.correspondences())};
          },
          "As the kernels and consimd.register take them.");
}

}  // namespace

void bind_problems(nb::module_& module) {
  bind_problem(module);
  const HardProblemOptions d;
  module.def(
      "noise_study_problem", &noise_study, nb::arg("correspondences") = d.correspondences,
      nb::arg("outlier_ratio") = d.outlier_ratio, nb::arg("sigma") = d.sigma, nb::arg("half_extent") = d.half_extent,
      nb::arg("seed") = d.seed, nb::arg("trial") = d.trial,
      "A problem of the noise study: points in a cube of +-half_extent metres under a random motion, a share\n"
      "outlier_ratio in [0, 1] of the targets random, Gaussian noise of sigma metres an axis on the others. The\n"
      "same bytes for the same arguments. ValueError on one outside its range.");
  module.def(
      "family_problem", &of_family, nb::arg("family"), nb::arg("correspondences") = d.correspondences,
      nb::arg("outlier_ratio") = d.outlier_ratio, nb::arg("sigma") = d.sigma, nb::arg("half_extent") = d.half_extent,
      nb::arg("seed") = d.seed, nb::arg("trial") = d.trial,
      "A problem of a family, see problem_families(); the other arguments are those of noise_study_problem, which "
      "makes\n"
      "the family 'gaussian'. outlier_ratio = 1 gives a problem without a true pose. ValueError on an unknown family.");
  module.def(
      "problem_families",
      [] {
        nb::dict all;
        for (const synth::ProblemFamily& family : synth::problem_families()) {
          all[nb::cast(family.name)] = family.sentence;
        }
        return all;
      },
      nb::sig("def problem_families() -> dict[str, str]"), "The families of problems by name, each with a sentence.");
  module.def(
      "hard_problem", &hard, nb::kw_only(), nb::arg("correspondences") = d.correspondences,
      nb::arg("outlier_ratio") = d.outlier_ratio, nb::arg("sigma") = d.sigma, nb::arg("half_extent") = d.half_extent,
      nb::arg("seed") = d.seed, nb::arg("trial") = d.trial, nb::arg("scene") = name_of(d.scene),
      nb::arg("thickness") = d.thickness, nb::arg("parts") = d.parts, nb::arg("outliers") = name_of(d.outliers),
      nb::arg("clusters") = d.clusters, nb::arg("cluster_sigma") = d.cluster_sigma,
      nb::arg("matches_per_point") = d.matches_per_point, nb::arg("decoy_share") = d.decoy_share,
      nb::arg("symmetric") = d.symmetric, nb::arg("noise") = name_of(d.noise),
      nb::arg("degrees_of_freedom") = d.degrees_of_freedom, nb::arg("anisotropy") = d.anisotropy,
      nb::arg("duplicates") = d.duplicates, nb::arg("mirrored") = d.mirrored, nb::arg("quantum") = d.quantum,
      nb::arg("source_offset") = d.source_offset, nb::arg("target_offset") = d.target_offset,
      nb::arg("units_per_metre") = d.units_per_metre,
      "The noise study's problem, made harder in one way by each option past `trial`.\n\n"
      "scene: 'volume'; 'planar' or 'linear', `thickness` metres thick; 'rings' of a scanner on the ground, 'poles',\n"
      "    'lines', each of `parts`; 'corridor'; 'room'; 'street'; 'facade' of `parts` columns of windows; 'grid' of "
      "`parts` "
      "nodes\n"
      "    an edge. Their sizes go with half_extent\n"
      "outliers: 'uniform'; 'permuted' among themselves; 'clustered' in `clusters` of `cluster_sigma` metres;\n"
      "    'one_to_many' or 'many_to_many' with `matches_per_point`; 'alike': with points of another scene of the "
      "kind\n"
      "    that look the same: at the same distance from the origin of a volume; on the same ring, line, or face of "
      "the\n"
      "    room; of the same height on any pole; of the same place in the cross-section of a corridor or street; the "
      "same corners of\n"
      "    any windows; anywhere on a plane, rod or grid\n"
      "decoy_share: outliers, as a share of the inliers' number, that follow a second motion\n"
      "symmetric: the scene is its own image under a half turn\n"
      "noise: 'gaussian', 'range_dependent', 'student_t' with `degrees_of_freedom` >= 3, or 'anisotropic': its "
      "deviation\n"
      "    along the ray from the source's origin is `anisotropy` times that across\n"
      "duplicates: copies of random rows, on top\n"
      "mirrored: only a reflection explains the data; no row is an inlier\n"
      "quantum: rounds coordinates to its multiples, metres; 0 does not\n"
      "source_offset, target_offset: added to the points, metres\n"
      "units_per_metre: 1000 gives millimetres\n\n"
      "outlier_ratio = 1 gives a problem without a true pose. ValueError on an option outside its range.");
  module.def(
      "stand_in_problem", &stand_in, nb::arg("name"), nb::arg("seed") = 1, nb::arg("trial") = 0,
      "A pair of synthetic scans with the numbers of one of the TCF paper's sequences, see stand_ins(). Metres.\n"
      "Not real data. ValueError on an unknown name.");
  module.def(
      "stand_ins",
      [] {
        nb::dict all;
        for (const synth::StandIn& one : synth::stand_ins()) all[nb::cast(one.name)] = describe(one);
        return all;
      },
      nb::sig("def stand_ins() -> dict[str, dict[str, str | int | float]]"),
      "The stand-ins by name: data set, sequence, distance of the scanners and of inliers, noise bound (metres), "
      "number\n"
      "of correspondences, share of inliers.");
  module.def("noise_study_bound", &synth::noise_study_bound, nb::arg("sigma"),
             "The noise bound that the study gives a solver: 3 sigma.");
  module.def(
      "write_problem", &synth::write_problem, nb::arg("problem"), nb::arg("folder"),
      nb::call_guard<nb::gil_scoped_release>(),
      "Writes correspondences.txt (N x 6), pose.txt (4 x 4), labels.txt and case.json to a folder, which is made if\n"
      "missing, as `consimd generate` does: what the commands `register` and `compare` read. RuntimeError naming the "
      "path if it cannot.");
}

}  // namespace consimd::python
