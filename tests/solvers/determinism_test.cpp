// The same bits for any number of threads, any instruction set and any caller.
#include <consimd/solvers/one_point_ransac.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/three_point_ransac.hpp>
#include <consimd/solvers/two_point_ransac.hpp>
#include <consimd/synth/hard_problems.hpp>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <bit>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

void append(std::vector<std::uint64_t>& bits, const RigidTransform& T) {
  for (const double x : T.matrix().reshaped()) bits.push_back(std::bit_cast<std::uint64_t>(x));
}

/// All of a registration that must not vary: everything but times, the instruction set and the number of threads.
std::vector<std::uint64_t> bits_of(const Registration& result) {
  std::vector<std::uint64_t> bits{static_cast<std::uint64_t>(result.status), result.seed, result.inliers.size()};
  for (const double x : {result.log10_false_poses, result.noise_bound, result.consistency_bound}) {
    bits.push_back(std::bit_cast<std::uint64_t>(x));
  }
  append(bits, result.T_target_source);
  for (const double x : result.covariance.reshaped()) bits.push_back(std::bit_cast<std::uint64_t>(x));
  bits.insert(bits.end(), result.inliers.begin(), result.inliers.end());
  if (result.runner_up) {
    append(bits, result.runner_up->T_target_source);
    bits.insert(bits.end(),
                {result.runner_up->support, std::bit_cast<std::uint64_t>(result.runner_up->log10_false_poses)});
  }
  for (const StageReport& stage : result.stages) {
    bits.insert(bits.end(), {stage.input, stage.output, stage.iterations});
  }
  return bits;
}

struct DeterminismCase {
  std::string name;
  std::string_view solver;
  synth::HardProblemOptions options;
  std::optional<double> noise_bound = 3.0;
  bool has_runner_up = false;
};

void PrintTo(const DeterminismCase& c, std::ostream* out) { *out << c.name; }

class Determinism : public ::testing::TestWithParam<DeterminismCase> {
 protected:
  [[nodiscard]] std::vector<std::uint64_t> run() const {
    const Registration result =
        register_by_name(GetParam().solver, correspondences_, {.noise_bound = GetParam().noise_bound, .seed = 5});
    EXPECT_TRUE(result.runner_up || !GetParam().has_runner_up);
    return bits_of(result);
  }

  Correspondences correspondences_ = synth::hard_problem(GetParam().options).correspondences();
  // Threads beyond the processor's, so that arenas of four are real on small machines.
  tbb::global_control threads_{tbb::global_control::max_allowed_parallelism, 4};
};
INSTANTIATE_TEST_SUITE_P(
    Cases, Determinism,
    ::testing::Values(
        DeterminismCase{"few_outliers", "tcf", {.correspondences = 1000, .outlier_ratio = 0.3}},
        DeterminismCase{"many_outliers", "tcf", {.correspondences = 3000, .outlier_ratio = 0.98}},
        DeterminismCase{"many_rows", "tcf", {.correspondences = 40'000, .outlier_ratio = 0.95}},
        DeterminismCase{"no_pose", "tcf", {.correspondences = 500, .outlier_ratio = 1.0}},
        DeterminismCase{
            "two_poses", "tcf", {.correspondences = 2000, .outlier_ratio = 0.9, .decoy_share = 1.0}, 3.0, true},
        DeterminismCase{"doubtful", "tcf", {.correspondences = 300, .outlier_ratio = 0.97}},
        DeterminismCase{"no_bound", "tcf", {.correspondences = 300, .outlier_ratio = 0.9}, std::nullopt},
        DeterminismCase{
            "published_no_bound", "tcf-published", {.correspondences = 100, .outlier_ratio = 0.5}, std::nullopt},
        DeterminismCase{"published_few_outliers", "tcf-published", {.correspondences = 100, .outlier_ratio = 0.3}},
        DeterminismCase{"published_many_outliers", "tcf-published", {.correspondences = 300, .outlier_ratio = 0.9}}),
    [](const auto& test) { return test.param.name; });

TEST_P(Determinism, AnyNumberOfThreads) {
  const std::vector<std::uint64_t> expected = run();
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena arena(threads);
    for (int repetition = 0; repetition < 3; ++repetition) {
      arena.execute([&] {
        EXPECT_EQ(run(), expected) << threads << " threads";
        EXPECT_EQ(register_by_name("tcf", correspondences_, {.noise_bound = 3.0}).threads, threads);
      });
    }
  }
}

TEST_P(Determinism, EveryInstructionSet) {
  const Isa before = active_isa();
  const std::vector<std::uint64_t> expected = run();
  for (const Isa isa : supported_isas()) {
    set_active_isa(isa);
    EXPECT_EQ(run(), expected) << to_string(isa);
    EXPECT_EQ(register_by_name("tcf", correspondences_, {.noise_bound = 3.0}).isa, isa);
  }
  set_active_isa(before);
}

TEST_P(Determinism, InsideTheCallersLoop) {
  const std::vector<std::uint64_t> expected = run();
  std::vector<std::vector<std::uint64_t>> results(8);
  tbb::task_arena(4).execute(
      [&] { tbb::parallel_for(std::size_t{0}, results.size(), [&](std::size_t i) { results[i] = run(); }); });
  for (const auto& result : results) EXPECT_EQ(result, expected);
}

TEST(StageDeterminism, AnyNumberOfThreads) {
  const Problem problem = synth::hard_problem({.correspondences = 1000, .outlier_ratio = 0.9});
  const Correspondences correspondences = problem.correspondences();
  tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  std::vector<ConsensusSet> first;
  for (const int threads : {1, 2, 4}) {
    std::vector<ConsensusSet> sets;
    tbb::task_arena(threads).execute([&] {
      sets.push_back(one_point_ransac(correspondences, {.consistency_bound = 6.0}));
      sets.push_back(
          two_point_ransac(correspondences, sets[0].members, {.consistency_bound = 6.0, .angle_bound = 6.0}));
      sets.push_back(three_point_ransac(correspondences, sets[1].members, {.noise_bound = 3.0}).consensus);
    });
    if (first.empty()) first = sets;
    for (std::size_t s = 0; s < sets.size(); ++s) {
      EXPECT_EQ(sets[s].members, first[s].members) << "stage " << s << ", " << threads << " threads";
      EXPECT_EQ(sets[s].iterations, first[s].iterations) << "stage " << s << ", " << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace consimd::test
