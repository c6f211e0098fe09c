// A RANSAC loop of one's own on consimd's batch kernels, in a task arena of the caller.
//
// The loop is the textbook's: draw three correspondences, fit a pose, count the correspondences within the noise bound,
// until the best pose's inliers would have been drawn with 99 % confidence. Before: an Eigen expression counts, pose by
// pose. After: three_point_fits and alignment_counts take the samples of a task at once. Both see the same samples.
//
// Several scans are registered at once from a loop in the caller's arena, and each registration runs its tasks in a
// loop of its own inside that one. oneTBB lets threads that wait for an inner loop help wherever there is work in the
// arena, so nesting neither deadlocks nor takes more threads than the arena has. Two rules keep it so: hold no lock
// across a parallel call, and keep no thread-local state across one (or wrap the call in
// tbb::this_task_arena::isolate), since a waiting thread may start on another scan.
#include <algorithm>
#include <cmath>
#include <random>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <Eigen/Geometry>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/three_point_fit.hpp>

#include "before_and_after.hpp"

namespace {

using consimd::IndexTriple;
using consimd::RigidTransform;

constexpr std::size_t kSamplesPerTask = 512;
constexpr std::size_t kTasksPerRound = 16;  // between two looks at the stopping rule
constexpr std::size_t kMaxSamples = 1'000'000;
constexpr double kConfidence = 0.99;

// --- Before: one pose after the other. This is the fastest of the loops that are quickly written, in single precision
// as the kernels are.
class EigenCounter {
 public:
  explicit EigenCounter(const example::Input& input)
      : p_(columns(input.problem.source)),
        q_(columns(input.problem.target)),
        squared_bound_(static_cast<float>(input.noise_bound * input.noise_bound)) {}

  void operator()(std::span<const IndexTriple> samples, std::span<std::uint32_t> counts) const {
    for (std::size_t h = 0; h < samples.size(); ++h) {
      const auto [i, j, k] = samples[h];
      Eigen::Matrix3f source, target;
      source << p_.col(i), p_.col(j), p_.col(k);
      target << q_.col(i), q_.col(j), q_.col(k);
      const Eigen::Matrix4f T = Eigen::umeyama(source, target, /*with_scaling=*/false);
      const Eigen::Matrix3f R = T.topLeftCorner<3, 3>();
      const Eigen::Vector3f t = T.topRightCorner<3, 1>();
      counts[h] = static_cast<std::uint32_t>(
          (((R * p_).colwise() + t - q_).colwise().squaredNorm().array() < squared_bound_).count());
    }
  }

 private:
  static Eigen::Matrix3Xf columns(const std::vector<double>& points) {
    return Eigen::Map<const Eigen::Matrix3Xd>(points.data(), 3, static_cast<Eigen::Index>(points.size() / 3))
        .cast<float>();
  }
  Eigen::Matrix3Xf p_, q_;
  float squared_bound_;
};

// --- After: all samples of a task in two calls.
class KernelCounter {
 public:
  explicit KernelCounter(const example::Input& input)
      : correspondences_(input.problem.correspondences()), noise_bound_(input.noise_bound) {}

  void operator()(std::span<const IndexTriple> samples, std::span<std::uint32_t> counts) const {
    std::vector<consimd::WorkingPose> poses(samples.size());
    consimd::three_point_fits(correspondences_, samples, poses);
    consimd::alignment_counts(correspondences_, poses, noise_bound_, counts);
  }

 private:
  consimd::Correspondences correspondences_;
  double noise_bound_;
};

// --- The loop, the same for both.

/// Samples of a task: a function of scan and task alone, whatever thread draws them. Too near, or the same point in two
/// rows, two correspondences hardly fix a rotation. check_lengths leaves out those whose lengths differ in the clouds.
std::vector<IndexTriple> draw(const example::Input& input, bool check_lengths, std::size_t scan, std::size_t task) {
  const double bound = 2.0 * input.noise_bound;
  const auto usable = [&](std::uint32_t i, std::uint32_t j) {
    const double source = example::distance(input.problem.source, i, j);
    const double target = example::distance(input.problem.target, i, j);
    return std::min(source, target) > bound && (!check_lengths || std::abs(source - target) < bound);
  };
  std::mt19937_64 random((scan << 32) + task);
  std::uniform_int_distribution<std::uint32_t> row(0, static_cast<std::uint32_t>(input.problem.size() - 1));
  std::vector<IndexTriple> drawn;
  for (std::size_t n = 0; n < kSamplesPerTask; ++n) {
    const IndexTriple s{row(random), row(random), row(random)};
    if (usable(s.first, s.second) && usable(s.second, s.third) && usable(s.third, s.first)) drawn.push_back(s);
  }
  return drawn;
}

struct Best {
  IndexTriple sample{};
  std::uint32_t count = 0;
};

template <typename Counter>
RigidTransform ransac(const example::Input& input, bool check_lengths, std::size_t scan, example::TaskGauge& gauge) {
  const Counter count_inliers(input);
  Best best;
  std::vector<Best> bests(kTasksPerRound);
  double needed = kMaxSamples;
  for (std::size_t round = 0; static_cast<double>(round * kTasksPerRound * kSamplesPerTask) < needed; ++round) {
    tbb::parallel_for(std::size_t{0}, kTasksPerRound, [&](std::size_t task) {
      const example::TaskGauge::Running running(gauge);
      const std::vector<IndexTriple> samples = draw(input, check_lengths, scan, round * kTasksPerRound + task);
      std::vector<std::uint32_t> counts(samples.size());
      count_inliers(samples, counts);
      const auto largest = std::max_element(counts.begin(), counts.end());
      bests[task] = largest == counts.end()
                        ? Best{}
                        : Best{samples[static_cast<std::size_t>(largest - counts.begin())], *largest};
    });
    // In the order of the tasks, not in that of their ends: the same result on any number of threads.
    for (const Best& candidate : bests) {
      if (candidate.count > best.count) best = candidate;
    }
    const double inliers = static_cast<double>(best.count) / static_cast<double>(input.problem.size());
    needed = std::min(needed, std::log(1.0 - kConfidence) / std::log1p(-std::pow(inliers, 3)));
  }
  if (best.count == 0) return RigidTransform::Identity();
  const std::uint32_t rows[] = {best.sample.first, best.sample.second, best.sample.third};
  return example::refit(input, example::least_squares_pose(input.problem, rows));
}

// --- The caller: registers `runs` scans at once, in its arena. Here they are the same scan with other samples.
template <typename Counter>
example::Method register_scans(const char* name, const example::Input& input, bool check_lengths,
                               tbb::task_arena& arena, example::TaskGauge& gauge) {
  example::Method method{name, std::vector<example::Run>(input.runs)};
  std::vector<double> seconds(3);
  for (double& repetition : seconds) {
    repetition = example::seconds_of([&] {
      arena.execute([&] {
        tbb::parallel_for(std::size_t{0}, input.runs, [&](std::size_t scan) {
          method.runs[scan].T_target_source = ransac<Counter>(input, check_lengths, scan, gauge);
        });
      });
    });
  }
  for (example::Run& run : method.runs) run.seconds = example::median(seconds) / static_cast<double>(input.runs);
  return method;
}

}  // namespace

int main(int argc, char** argv) {
  const example::Input input = example::read_input(
      argc, argv, "RANSAC that counts inliers with Eigen, then with consimd, in a task arena of the caller.",
      {.correspondences = 3000, .outlier_ratio = 0.9, .sigma = 0.2});

  tbb::task_arena one(1), two(2);
  example::TaskGauge in_one, in_two;
  const std::vector<example::Method> methods = {
      register_scans<EigenCounter>("Eigen, 1 thread", input, false, one, in_one),
      register_scans<KernelCounter>("consimd, 1 thread", input, false, one, in_one),
      register_scans<EigenCounter>("Eigen, 2 threads", input, false, two, in_two),
      register_scans<KernelCounter>("consimd, 2 threads", input, false, two, in_two),
      register_scans<EigenCounter>("Eigen, lengths checked, 1 thread", input, true, one, in_one),
      register_scans<KernelCounter>("consimd, lengths checked, 1 thr.", input, true, one, in_one),
  };
  example::print_table(input, methods);

  bool fine = example::check(std::ranges::all_of(methods, [&](const auto& m) { return all_good(input, m); }),
                             "every pose is good");
  fine &= example::check(same_poses(methods[1], methods[3]), "1 and 2 threads give the same bits");
  fine &= example::check(in_one.most() == 1 && in_two.most() <= 2,
                         "no more tasks at once than the arenas' 1 and 2: " + std::to_string(in_one.most()) + " and " +
                             std::to_string(in_two.most()));
  return fine ? 0 : 1;
}
