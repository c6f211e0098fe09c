#include <consimd/solvers/tcf_published.hpp>

#include <utility>

#include <consimd/solvers/one_point_ransac.hpp>
#include <consimd/solvers/sa_cauchy_irls.hpp>
#include <consimd/solvers/three_point_ransac.hpp>
#include <consimd/solvers/two_point_ransac.hpp>

#include "scale/rival_scale.hpp"
#include "support/best_poses.hpp"
#include "support/pose_candidate.hpp"
#include "tcf/tcf_options.hpp"
#include "verdict/final_pose.hpp"
#include "verdict/pose_checks.hpp"
#include "verdict/pose_test.hpp"

namespace consimd {
namespace {

void solve(const Correspondences& correspondences, const TcfPublishedOptions& options, Registration& result) {
  const double tau = options.noise_bound;
  if (detail::coincident_or_collinear(correspondences)) {
    result.status = Status::degenerate_geometry;
    return;
  }
  // Its stages take some milliseconds each: between them is where it can be stopped.
  const auto run_stage = [&](std::string name, std::size_t input, auto&& stage) {
    result.stopped = result.stopped || options.stop.met();
    StageReport report{std::move(name), input};
    if (!result.stopped) {
      const detail::StageClock clock(report.seconds);
      stage(report);
    }
    result.stages.push_back(std::move(report));
  };

  ConsensusSet one;
  run_stage("one_point", correspondences.size(), [&](StageReport& report) {
    one = one_point_ransac(correspondences, {.consistency_bound = 2.0 * tau,
                                             .confidence = options.confidence,
                                             .max_iterations = options.max_iterations,
                                             .prune = false,
                                             .seed = options.seed});
    report.output = one.members.size();
    report.iterations = one.iterations;
  });

  ConsensusSet two;
  run_stage("two_point", one.members.size(), [&](StageReport& report) {
    two = two_point_ransac(correspondences, one.members,
                           {.consistency_bound = 2.0 * tau,
                            .angle_bound = tau,
                            .confidence = options.confidence,
                            .max_iterations = options.max_iterations,
                            .angle_test = AngleTest::as_printed,
                            .prune = false,
                            .seed = options.seed});
    report.output = two.members.size();
    report.iterations = two.iterations;
  });

  ThreePointResult three;
  run_stage("three_point", two.members.size(), [&](StageReport& report) {
    three = three_point_ransac(correspondences, two.members,
                               {.noise_bound = tau,
                                .confidence = options.confidence,
                                .max_iterations = options.max_iterations,
                                .seed = options.seed});
    report.output = three.consensus.members.size();
    report.iterations = three.consensus.iterations;
  });
  if (three.consensus.members.size() < 3) {
    result.status = Status::no_consensus;
    return;
  }

  IrlsResult irls;
  run_stage("irls", three.consensus.members.size(), [&](StageReport& report) {
    irls = sa_cauchy_irls(correspondences, three.consensus.members, {.rule = SaCauchyIrlsOptions::Rule::as_printed});
    report.output = irls.members.size();
    report.iterations = irls.rounds;
  });
  if (result.stopped) {
    result.status = Status::no_consensus;
    return;
  }
  if (!irls.fit.determined()) {
    result.status = Status::degenerate_geometry;
    return;
  }
  detail::BestPoses poses(correspondences, tau);
  poses.offer(detail::scored(correspondences.view(), to_working_pose(irls.fit.pose), tau));
  const detail::PoseTest test = {tau, options.bounds_tried};
  detail::finish_and_conclude(correspondences, test, poses, two.members, true, result, detail::Refinement::none);
  // The poses that are compared are of single precision; the paper's is not.
  if (result.has_pose()) result.T_target_source = to_caller_frame(irls.fit.pose, correspondences);
}

}  // namespace

Registration register_tcf_published(const Correspondences& correspondences, const TcfPublishedOptions& options) {
  detail::require_options(detail::tcf_published_options(), options);
  return detail::run_at_known_scale(correspondences, options, solve);
}

}  // namespace consimd
