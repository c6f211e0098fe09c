// A PCL program whose outlier rejection, pcl::registration::CorrespondenceRejectorSampleConsensus, gives way to
// consimd.
//
// Before: the rejector (10 000 iterations), then the rigid fit to the correspondences that it leaves. After: one call,
// register_tcf, on the same clouds and correspondences; it gives the pose and the correspondences to keep. Matching
// before it and whatever follows it in the program stay as they are.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <oneapi/tbb/task_arena.h>
#include <pcl/correspondence.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/correspondence_rejection_sample_consensus.h>
#include <pcl/registration/transformation_estimation_svd.h>

#include <consimd/kernels/pcl_correspondences.hpp>
#include <consimd/solvers/tcf.hpp>

#include "before_and_after.hpp"

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// What a PCL program has when it comes to rejection.
struct Scans {
  Cloud::Ptr source{new Cloud};
  Cloud::Ptr target{new Cloud};
  pcl::Correspondences matches;
};

/// Clouds of the input's points; the matches between them in random order, since PCL draws from a fixed seed.
Scans scans_of(const consimd::synth::Problem& problem, std::size_t run) {
  const auto point = [](const double* p) {
    return pcl::PointXYZ(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
  };
  Scans scans;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    scans.source->push_back(point(&problem.source[3 * k]));
    scans.target->push_back(point(&problem.target[3 * k]));
    scans.matches.emplace_back(static_cast<int>(k), static_cast<int>(k), 0.0f);
  }
  std::shuffle(scans.matches.begin(), scans.matches.end(), std::mt19937_64(run));
  return scans;
}

// --- Before.
Eigen::Matrix4f with_pcl(const Scans& scans, double noise_bound, pcl::Correspondences& kept) {
  pcl::registration::CorrespondenceRejectorSampleConsensus<pcl::PointXYZ> rejector;
  rejector.setInputSource(scans.source);
  rejector.setInputTarget(scans.target);
  rejector.setInlierThreshold(noise_bound);
  rejector.setMaximumIterations(10'000);
  rejector.getRemainingCorrespondences(scans.matches, kept);

  Eigen::Matrix4f T_target_source;
  pcl::registration::TransformationEstimationSVD<pcl::PointXYZ, pcl::PointXYZ> fit;
  fit.estimateRigidTransformation(*scans.source, *scans.target, kept, T_target_source);
  return T_target_source;
}

// --- After.
Eigen::Matrix4f with_consimd(const Scans& scans, double noise_bound, pcl::Correspondences& kept) {
  const consimd::Correspondences correspondences =
      consimd::pcl_correspondences(*scans.source, *scans.target, scans.matches);
  const consimd::Registration registration = consimd::register_tcf(correspondences, {.noise_bound = noise_bound});
  kept = consimd::matches_subset(scans.matches, registration.inliers);
  return registration.T_target_source.matrix().cast<float>();
}

template <typename Registration>
example::Method measured(const std::string& name, const example::Input& input, const Registration& registration) {
  example::Method method{name, {}};
  std::size_t kept_inliers = 0, kept_matches = 0;
  for (std::size_t run = 0; run < input.runs; ++run) {
    const Scans scans = scans_of(input.problem, run);
    pcl::Correspondences kept;
    Eigen::Matrix4f T;
    const double seconds = example::seconds_of([&] { T = registration(scans, input.noise_bound, kept); });
    consimd::RigidTransform T_target_source;
    T_target_source.matrix() = T.cast<double>();
    method.runs.push_back({T_target_source, seconds});
    kept_matches += kept.size();
    for (const pcl::Correspondence& match : kept) {
      kept_inliers += input.problem.is_inlier[static_cast<std::size_t>(match.index_query)];
    }
  }
  std::printf("%s: keeps %zu matches, %zu of them true inliers\n", name.c_str(), kept_matches / input.runs,
              kept_inliers / input.runs);
  return method;
}

}  // namespace

int main(int argc, char** argv) {
  const example::Input input = example::read_input(
      argc, argv, "Outlier rejection by PCL's CorrespondenceRejectorSampleConsensus, then by consimd.",
      {.correspondences = 2000, .outlier_ratio = 0.8, .sigma = 0.2});

  tbb::task_arena one_thread(1);
  const std::vector<example::Method> methods = {
      measured("PCL, 10 000 iterations", input, with_pcl),
      measured("consimd, 1 thread", input,
               [&](auto&&... arguments) { return one_thread.execute([&] { return with_consimd(arguments...); }); }),
      measured("consimd, all threads", input, with_consimd),
  };
  example::print_table(input, methods);

  bool fine =
      example::check(all_good(input, methods[1]) && all_good(input, methods[2]), "every pose of consimd is good");
  // On recorded scans PCL may miss: that is what the table shows.
  if (input.synthetic) fine &= example::check(all_good(input, methods[0]), "every pose of PCL is good");
  return fine ? 0 : 1;
}
