#include "mutual_matches.hpp"

#include <algorithm>
#include <limits>

namespace consimd::synth {
namespace {

constexpr std::size_t kMost = 8;

/// The `k` nearest met so far, nearest first.
class Nearest {
 public:
  void offer(float distance, std::uint32_t index, std::size_t k) {
    if (distance >= distances_[k - 1]) return;
    std::size_t place = k - 1;
    for (; place > 0 && distances_[place - 1] > distance; --place) {
      distances_[place] = distances_[place - 1];
      indices_[place] = indices_[place - 1];
    }
    distances_[place] = distance;
    indices_[place] = index;
  }

  [[nodiscard]] bool holds(std::uint32_t index, std::size_t k) const {
    return std::find(indices_.begin(), indices_.begin() + static_cast<std::ptrdiff_t>(k), index) !=
           indices_.begin() + static_cast<std::ptrdiff_t>(k);
  }

  [[nodiscard]] std::uint32_t operator[](std::size_t place) const { return indices_[place]; }

 private:
  static std::array<float, kMost> far_away() {
    std::array<float, kMost> distances;
    distances.fill(std::numeric_limits<float>::infinity());
    return distances;
  }
  static std::array<std::uint32_t, kMost> none() {
    std::array<std::uint32_t, kMost> indices;
    indices.fill(std::numeric_limits<std::uint32_t>::max());
    return indices;
  }

  std::array<float, kMost> distances_ = far_away();
  std::array<std::uint32_t, kMost> indices_ = none();
};

float squared_distance(const Descriptor& a, const Descriptor& b) {
  float sum = 0.0F;
  for (std::size_t i = 0; i < a.look.size(); ++i) sum += (a.look[i] - b.look[i]) * (a.look[i] - b.look[i]);
  return sum;
}

}  // namespace

std::vector<Match> mutual_matches(std::span<const Descriptor> source, std::span<const Descriptor> target,
                                  std::size_t k) {
  std::vector<Nearest> of_source(source.size()), of_target(target.size());
  for (std::uint32_t i = 0; i < source.size(); ++i) {
    for (std::uint32_t j = 0; j < target.size(); ++j) {
      if (source[i].kind != target[j].kind) continue;
      const float distance = squared_distance(source[i], target[j]);
      of_source[i].offer(distance, j, k);
      of_target[j].offer(distance, i, k);
    }
  }
  std::vector<Match> matches;
  for (std::uint32_t i = 0; i < source.size(); ++i) {
    const std::size_t first = matches.size();
    for (std::size_t place = 0; place < k; ++place) {
      const std::uint32_t j = of_source[i][place];
      if (j < target.size() && of_target[j].holds(i, k)) matches.push_back({i, j});
    }
    std::sort(matches.begin() + static_cast<std::ptrdiff_t>(first), matches.end(),
              [](const Match& a, const Match& b) { return a.target < b.target; });
  }
  return matches;
}

}  // namespace consimd::synth
