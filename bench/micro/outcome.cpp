#include "outcome.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>

namespace consimd::bench {
namespace {

template <typename T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

std::span<const std::uint64_t> all_rows(const ConsistencyMatrix& matrix) {
  return {matrix.data(), matrix.size() * matrix.words()};
}

bool close(double a, double reference) { return std::abs(a - reference) <= 3.0 + 0.01 * std::abs(reference); }

bool close(const WorkingPose& a, const WorkingPose& b) {
  constexpr float kTolerance = 0.01f;
  const auto near = [](float x, float y) { return std::abs(x - y) <= kTolerance; };
  return std::equal(std::begin(a.rotation), std::end(a.rotation), std::begin(b.rotation), near) &&
         std::equal(std::begin(a.translation), std::end(a.translation), std::begin(b.translation), near);
}

bool close(const RigidMoments& a, const RigidMoments& b) {
  const auto near = [tolerance = 1e-3 * b.weight](double x, double y) { return std::abs(x - y) <= tolerance; };
  return near(a.weight, b.weight) && std::equal(std::begin(a.source), std::end(a.source), std::begin(b.source), near) &&
         std::equal(std::begin(a.target), std::end(a.target), std::begin(b.target), near) &&
         std::equal(std::begin(a.cross), std::end(a.cross), std::begin(b.cross), near);
}

}  // namespace

bool identical(const Outcome& a, const Outcome& b) {
  return same_bytes<std::uint32_t>(a.counts, b.counts) && same_bytes<std::uint64_t>(a.bits, b.bits) &&
         same_bytes<PoseSupport>(a.support, b.support) && same_bytes<WorkingPose>(a.poses, b.poses) &&
         same_bytes(std::span<const RigidMoments>(&a.moments, 1), std::span<const RigidMoments>(&b.moments, 1)) &&
         same_bytes<float>(a.sums, b.sums) && same_bytes(all_rows(a.matrix), all_rows(b.matrix));
}

bool close(const Outcome& baseline, const Outcome& reference) {
  if (baseline.counts.size() != reference.counts.size() || baseline.support.size() != reference.support.size() ||
      baseline.poses.size() != reference.poses.size() || baseline.sums.size() != reference.sums.size()) {
    return false;
  }
  for (std::size_t r = 0; r < baseline.sums.size(); ++r) {
    if (!close(static_cast<double>(baseline.sums[r]), static_cast<double>(reference.sums[r]))) return false;
  }
  for (std::size_t h = 0; h < baseline.counts.size(); ++h) {
    if (!close(static_cast<double>(baseline.counts[h]), static_cast<double>(reference.counts[h]))) return false;
  }
  for (std::size_t h = 0; h < baseline.support.size(); ++h) {
    if (!close(static_cast<double>(baseline.support[h].score), static_cast<double>(reference.support[h].score))) {
      return false;
    }
  }
  std::size_t close_poses = 0;
  for (std::size_t h = 0; h < baseline.poses.size(); ++h) {
    if (close(baseline.poses[h], reference.poses[h])) ++close_poses;
  }
  return 100 * close_poses >= 98 * baseline.poses.size() && close(baseline.moments, reference.moments);
}

}  // namespace consimd::bench
