#include "support/row_blocks.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>
#include <vector>

namespace consimd::detail::row_blocks {
namespace {

// A block is worth its scheduling: a pose is tested on it in some 2 us. Fewer blocks than these are worked on by the
// caller alone.
constexpr std::size_t kRows = 8192;
constexpr std::size_t kFewBlocks = 4;
static_assert(kRows % kBlock == 0);

std::size_t blocks_of(const CorrespondenceView& view) { return (view.size() + kRows - 1) / kRows; }

// task(0) to task(count - 1)
template <typename Task>
void run(std::size_t count, const Task& task) {
  if (count < kFewBlocks || tbb::this_task_arena::max_concurrency() == 1) {
    for (std::size_t i = 0; i < count; ++i) task(i);
  } else {
    tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, count, task); });
  }
}

void add(const RigidMoments& part, RigidMoments& sum) {
  const auto add_each = [](const auto& from, auto& to) {
    std::transform(std::begin(from), std::end(from), std::begin(to), std::begin(to), std::plus<>());
  };
  sum.weight += part.weight;
  add_each(part.source, sum.source);
  add_each(part.target, sum.target);
  add_each(part.cross, sum.cross);
  add_each(part.source_scatter, sum.source_scatter);
  sum.residual += part.residual;
}

CorrespondenceView block(const CorrespondenceView& view, std::size_t b) { return view.rows(b * kRows, kRows); }

}  // namespace

void alignment_scores(const CorrespondenceView& view, std::span<const WorkingPose> poses, double bound,
                      std::span<PoseSupport> support) {
  const std::size_t blocks = blocks_of(view);
  if (blocks <= 1) return consimd::alignment_scores(view, poses, bound, support);
  std::vector<PoseSupport> parts(blocks * poses.size());
  run(blocks, [&](std::size_t b) {
    consimd::alignment_scores(block(view, b), poses, bound, std::span(parts).subspan(b * poses.size(), poses.size()));
  });
  for (std::size_t h = 0; h < poses.size(); ++h) {
    support[h] = {};
    for (std::size_t b = 0; b < blocks; ++b) {
      support[h].count += parts[b * poses.size() + h].count;
      support[h].score += parts[b * poses.size() + h].score;
    }
  }
}

std::uint32_t alignment_bits(const CorrespondenceView& view, const WorkingPose& pose, double bound,
                             std::span<std::uint64_t> bits) {
  std::vector<std::uint32_t> counts(blocks_of(view));
  run(counts.size(), [&](std::size_t b) {
    const CorrespondenceView rows = block(view, b);
    consimd::alignment_bits(rows, std::span(&pose, 1), bound, bits.subspan(b * kRows / kBlock, rows.words()),
                            std::span(counts).subspan(b, 1));
  });
  return std::accumulate(counts.begin(), counts.end(), 0U);
}

std::uint32_t alignment_count(const CorrespondenceView& view, const WorkingPose& pose, double bound) {
  std::vector<std::uint32_t> counts(blocks_of(view));
  run(counts.size(), [&](std::size_t b) {
    consimd::alignment_counts(block(view, b), std::span(&pose, 1), bound, std::span(counts).subspan(b, 1));
  });
  return std::accumulate(counts.begin(), counts.end(), 0U);
}

void mismatched_counts(const CorrespondenceView& view, const WorkingPose& pose, double bound,
                       std::span<const std::uint32_t> shifts, std::span<std::uint32_t> counts) {
  if (blocks_of(view) <= 1) return consimd::mismatched_counts(view, pose, bound, shifts, counts);
  run(shifts.size(), [&](std::size_t s) {
    consimd::mismatched_counts(view, pose, bound, shifts.subspan(s, 1), counts.subspan(s, 1));
  });
}

RigidMoments robust_moments(const CorrespondenceView& view, const WorkingPose& pose, const RobustWeight& weight) {
  const std::size_t blocks = blocks_of(view);
  if (blocks <= 1) return consimd::robust_moments(view, pose, weight);
  std::vector<RigidMoments> parts(blocks);
  run(blocks, [&](std::size_t b) { parts[b] = consimd::robust_moments(block(view, b), pose, weight); });
  RigidMoments sum = parts.front();
  for (std::size_t b = 1; b < blocks; ++b) add(parts[b], sum);
  return sum;
}

RigidFit truncated_fit(const CorrespondenceView& view, const WorkingPose& pose, double bound) {
  return rigid_fit(row_blocks::robust_moments(view, pose, {WeightFunction::truncated, bound, bound, 0.0}));
}

}  // namespace consimd::detail::row_blocks
