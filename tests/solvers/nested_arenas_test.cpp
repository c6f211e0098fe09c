// Registrations from many threads and loops of the caller at once: no deadlock, the same bits, no more threads than the
// caller's arena has.
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/noise_study.hpp>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_scheduler_observer.h>
#include <oneapi/tbb/version.h>

#include <atomic>
#include <cstdint>
#include <new>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace consimd::test {
namespace {

constexpr int kArenaThreads = 2;
constexpr std::size_t kCallers = 8;

/// How many threads are in an arena at once, at most.
class ArenaThreads : public tbb::task_scheduler_observer {
 public:
  explicit ArenaThreads(tbb::task_arena& arena) : tbb::task_scheduler_observer(arena) { observe(true); }
  ~ArenaThreads() override { observe(false); }
  ArenaThreads(const ArenaThreads&) = delete;
  ArenaThreads& operator=(const ArenaThreads&) = delete;

  void on_scheduler_entry(bool /*is_worker*/) override {
    const int now = ++inside_;
    for (int seen = most_; seen < now && !most_.compare_exchange_weak(seen, now);) {
    }
  }
  void on_scheduler_exit(bool /*is_worker*/) override { --inside_; }

  [[nodiscard]] int most() const { return most_; }

 private:
  std::atomic<int> inside_ = 0;
  std::atomic<int> most_ = 0;
};

class NestedArenas : public ::testing::Test {
 protected:
  [[nodiscard]] Registration run(std::uint64_t seed) const {
    return register_tcf(correspondences_, {.noise_bound = synth::noise_study_bound(1.0), .seed = seed});
  }

  void SetUp() override {
    tbb::task_arena(1).execute([&] {
      for (std::uint64_t seed = 0; seed < kCallers; ++seed) expected_.push_back(run(seed));
    });
  }

#if TBB_INTERFACE_VERSION >= 12060
  // A worker that is still in the pool refers to the last observer that it told, which leak checkers see at exit.
  void TearDown() override { EXPECT_TRUE(tbb::finalize(scheduler_, std::nothrow)); }

  tbb::task_scheduler_handle scheduler_{tbb::attach{}};
#endif

  void expect_same(const std::vector<std::optional<Registration>>& results) const {
    for (std::size_t k = 0; k < kCallers; ++k) {
      ASSERT_TRUE(results[k]);
      EXPECT_EQ(results[k]->status, expected_[k].status);
      EXPECT_EQ(results[k]->inliers, expected_[k].inliers);
      EXPECT_EQ(results[k]->threads, kArenaThreads);
      EXPECT_EQ(results[k]->T_target_source.matrix(), expected_[k].T_target_source.matrix());
      EXPECT_EQ(results[k]->covariance, expected_[k].covariance);
    }
  }

  Correspondences correspondences_ =
      synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.95, .sigma = 1.0}).correspondences();
  std::vector<Registration> expected_;
  // More than the arenas', so that these could be outgrown on any machine.
  tbb::global_control threads_{tbb::global_control::max_allowed_parallelism, 8};
};

TEST_F(NestedArenas, ManyCallersOfOneArena) {
  tbb::task_arena arena(kArenaThreads);
  const ArenaThreads threads(arena);
  std::vector<std::optional<Registration>> results(kCallers);
  std::vector<std::thread> callers;
  callers.reserve(kCallers);
  for (std::size_t k = 0; k < kCallers; ++k) {
    callers.emplace_back([&, k] { arena.execute([&] { results[k] = run(k); }); });
  }
  for (std::thread& caller : callers) caller.join();
  expect_same(results);
  EXPECT_GE(threads.most(), 1);
  EXPECT_LE(threads.most(), kArenaThreads);
}

TEST_F(NestedArenas, AnArenaForEachCaller) {
  std::vector<std::optional<Registration>> results(kCallers);
  std::vector<int> most(kCallers);
  std::vector<std::thread> callers;
  callers.reserve(kCallers);
  for (std::size_t k = 0; k < kCallers; ++k) {
    callers.emplace_back([&, k] {
      tbb::task_arena arena(kArenaThreads);
      const ArenaThreads threads(arena);
      arena.execute([&] { results[k] = run(k); });
      most[k] = threads.most();
    });
  }
  for (std::thread& caller : callers) caller.join();
  expect_same(results);
  for (const int threads : most) {
    EXPECT_GE(threads, 1);
    EXPECT_LE(threads, kArenaThreads);
  }
}

TEST_F(NestedArenas, LoopInsideALoop) {
  tbb::task_arena arena(kArenaThreads);
  const ArenaThreads threads(arena);
  std::vector<std::optional<Registration>> results(kCallers);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, std::size_t{2}, [&](std::size_t half) {
      tbb::parallel_for(std::size_t{0}, kCallers / 2,
                        [&](std::size_t k) { results[half * kCallers / 2 + k] = run(half * kCallers / 2 + k); });
    });
  });
  expect_same(results);
  EXPECT_GE(threads.most(), 1);
  EXPECT_LE(threads.most(), kArenaThreads);
}

}  // namespace
}  // namespace consimd::test
