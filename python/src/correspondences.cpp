// Correspondences, and the instruction set that kernels over them run on.
#include <array>
#include <memory>
#include <utility>

#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <consimd/kernels/isa.hpp>

#include "array_arguments.hpp"
#include "array_results.hpp"
#include "bindings.hpp"

namespace consimd::python {
namespace {

std::shared_ptr<Correspondences> correspondences_from(ArrayLike source_like, ArrayLike target_like) {
  Points source(source_like, "source");
  Points target(target_like, "target");
  if (!source.single_precision() || !target.single_precision()) {
    source.widen();
    target.widen();
    const nb::gil_scoped_release unlocked;
    return std::make_shared<Correspondences>(source.span<double>(), target.span<double>());
  }
  const nb::gil_scoped_release unlocked;
  return std::make_shared<Correspondences>(source.span<float>(), target.span<float>());
}

/// (N, 3), as the axes lie in memory: a row's coordinates are padded_size() floats apart.
View<float, -1, 3> points_view(const float* first_axis, const CorrespondenceView& view, nb::handle owner) {
  return View<float, -1, 3>(first_axis, {view.size(), 3}, owner, {1, static_cast<std::int64_t>(view.padded_size())});
}

const Correspondences& rows_of(nb::handle self) { return *nb::cast<const SharedCorrespondences&>(self).rows; }

std::tuple<double, double, double> tuple_of(const std::array<double, 3>& xyz) { return {xyz[0], xyz[1], xyz[2]}; }

}  // namespace

void bind_isa(nb::module_& module) {
  module.def(
      "active_isa", [] { return to_string(active_isa()); },
      "The instruction set that kernels run on now: that of set_active_isa, else of the environment variable\n"
      "CONSIMD_ISA, else the widest supported. All give the same bits. ValueError if CONSIMD_ISA names none.");
  module.def(
      "set_active_isa", [](std::string_view isa) { set_active_isa(parse_isa(isa)); }, nb::arg("isa"),
      "Makes all later calls of the process run on one of supported_isas(). ValueError on another.");
  const auto names_of = [](std::span<const Isa> isas) {
    std::vector<std::string_view> names;
    for (const Isa isa : isas) names.push_back(to_string(isa));
    return names;
  };
  module.def(
      "known_isas", [names_of] { return names_of(known_isas()); },
      "Names of the instruction sets that there are kernels for, on any processor.");
  module.def(
      "supported_isas", [names_of] { return names_of(supported_isas()); },
      "Names of the instruction sets that this processor has, the narrowest, 'scalar', first.");
}

void bind_correspondences(nb::module_& module) {
  nb::class_<SharedCorrespondences>(module, "Correspondences",
                                    "N correspondences between two point clouds, as the kernels read them.\n\n"
                                    "The points are held in single precision in a working frame,\n"
                                    "    p' = scale * (p - source_centroid),  q' = scale * (q - target_centroid),\n"
                                    "computed in double precision, so that map coordinates and any unit keep their\n"
                                    "accuracy. Immutable: make it once and register it many times.")
      .def(
          "__init__",
          [](SharedCorrespondences* self, ArrayLike source, ArrayLike target,
             const std::array<double, 3>& source_viewpoint) {
            std::shared_ptr<Correspondences> rows = correspondences_from(source, target);
            rows->set_source_viewpoint(source_viewpoint);
            new (self) SharedCorrespondences{std::move(rows)};
          },
          nb::arg("source"), nb::arg("target"), nb::kw_only(),
          nb::arg("source_viewpoint") = std::array<double, 3>{0.0, 0.0, 0.0},
          "Copies corresponding points.\n\n"
          "source, target: (N, 3), any one unit of length. float32 and float64 arrays are read in place, whatever\n"
          "their strides; others are converted to float64 first.\n"
          "source_viewpoint: x, y and z of where the source was scanned from, in its own frame. Matches tend to keep\n"
          "the range about the sensor, which a verdict allows for; where nearly all rows keep ranges far better\n"
          "about another point it takes that.\n"
          "ValueError on another shape, on differing lengths,\n"
          "and at a coordinate that is not finite, naming its row.")
      .def("__len__", [](const SharedCorrespondences& self) { return self.rows->size(); })
      .def("__repr__",
           [](const SharedCorrespondences& self) {
             return "<consimd.Correspondences: " + std::to_string(self.rows->size()) + " rows>";
           })
      .def_prop_ro(
          "source", [](nb::handle self) { return points_view(rows_of(self).view().source(0), rows_of(self), self); },
          "(N, 3) float32, working frame. A read-only view.")
      .def_prop_ro(
          "target", [](nb::handle self) { return points_view(rows_of(self).view().target(0), rows_of(self), self); },
          "(N, 3) float32, working frame. A read-only view.")
      .def_prop_ro(
          "scale", [](const SharedCorrespondences& self) { return self.rows->scale(); },
          "Working-frame length of one unit of the caller's, a power of two.")
      .def_prop_ro(
          "source_centroid", [](const SharedCorrespondences& self) { return tuple_of(self.rows->source_centroid()); },
          "x, y and z of the source points' mean, caller's unit.")
      .def_prop_ro(
          "target_centroid", [](const SharedCorrespondences& self) { return tuple_of(self.rows->target_centroid()); },
          "x, y and z of the target points' mean, caller's unit.")
      .def_prop_ro(
          "source_viewpoint", [](const SharedCorrespondences& self) { return tuple_of(self.rows->source_viewpoint()); },
          "x, y and z of where the source was scanned from, caller's frame.")
      .def_prop_ro(
          "words", [](const SharedCorrespondences& self) { return self.rows->view().words(); },
          "64-bit words that a set of bits over the rows takes.")
      .def(
          "subset",
          [](const SharedCorrespondences& self, ArrayLike rows) {
            return SharedCorrespondences{
                std::make_shared<const Correspondences>(self.rows->subset(indices_from(rows, "rows")))};
          },
          nb::arg("rows"), "The chosen rows, (M,) whole numbers, in that order and the same working frame.");
}

}  // namespace consimd::python
