#include "outside_solvers.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <consimd/studies/outside_program.hpp>

#include "array_results.hpp"
#include "interruptible_call.hpp"

namespace consimd::python {
namespace {

/// [R | t], as `_outside.py` makes it of what a function returns.
using PoseRows = nb::ndarray<const double, nb::shape<3, 4>, nb::c_contig, nb::device::cpu>;
using Found = std::tuple<std::optional<PoseRows>, std::optional<std::vector<std::uint32_t>>, std::string>;

/// N x 3 without a copy: the array keeps what holds the points.
View<double, -1, 3> points_view(std::span<const double> points, const std::shared_ptr<const void>& holder) {
  auto* kept = new std::shared_ptr<const void>(holder);
  const nb::capsule owner(kept,
                          [](void* pointer) noexcept { delete static_cast<std::shared_ptr<const void>*>(pointer); });
  return View<double, -1, 3>(points.data(), {points.size() / 3, 3}, owner);
}

studies::OutsideReply to_reply(const Found& found, double seconds) {
  const auto& [pose, inliers, status] = found;
  studies::OutsideReply reply = std::nullopt;
  if (pose) {
    reply.pose = RigidTransform::Identity();
    reply.pose->affine() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(pose->data());
  }
  reply.inliers = inliers;
  reply.status = status;
  reply.seconds = seconds;
  return reply;
}

/// The function's errors name solver and problem by themselves.
studies::OutsideReply call(nb::handle function, const studies::OutsideProblem& problem) {
  const nb::gil_scoped_acquire locked;
  const nb::object source = nb::cast(points_view(problem.source, problem.points));
  const nb::object target = nb::cast(points_view(problem.target, problem.points));
  const auto start = std::chrono::steady_clock::now();
  const nb::object result = function(source, target, problem.noise_bound, problem.seed, nb::cast(problem.name));
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  return to_reply(nb::cast<Found>(result), seconds.count());
}

}  // namespace

studies::OutsideSolvers outside_solvers(const std::vector<OutsideEntry>& entries, double time_limit,
                                        const std::shared_ptr<const std::atomic<bool>>& stop) {
  const auto is_program = [](const OutsideEntry& entry) { return std::get<1>(entry).is_none(); };
  if (time_limit != studies::kDefaultTimeLimit && std::ranges::none_of(entries, is_program)) {
    throw std::invalid_argument(
        fmt::format("time_limit: {} s are for programs, 'exec:COMMAND', and solvers names none", time_limit));
  }
  studies::OutsideSolvers solvers;
  for (const auto& entry : entries) {
    const std::string& name = std::get<0>(entry);
    const nb::handle function = std::get<1>(entry);
    const std::string& command = std::get<2>(entry);
    const std::string& version = std::get<3>(entry);
    if (!is_program(entry)) {
      solvers.push_back(
          {.name = name,
           .command = command,
           .version = version,
           .solve = [function](const studies::OutsideProblem& problem) { return call(function, problem); }});
      continue;
    }
    std::optional<studies::OutsideProgram> program =
        studies::parse_outside_program(fmt::format("{}={}", name, command));
    if (!program) {
      throw std::invalid_argument(
          fmt::format("solver {}: expected exec:COMMAND or exec-binary:COMMAND, got '{}'", name, command));
    }
    program->version = version;
    program->time_limit = time_limit;
    program->stop_requested = [stop] { return stop->load(); };
    solvers.push_back(interruptible_result<studies::OutsideSolver>(
        [program = std::move(*program)] { return studies::start_outside_program(program); }));
  }
  return solvers;
}

}  // namespace consimd::python
