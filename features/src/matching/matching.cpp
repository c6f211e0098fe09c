#include <consimd/features/matching.hpp>

#include <consimd/kernels/descriptor_matches.hpp>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace consimd::features {
namespace {

void check(const MatchOptions& options) {
  if (options.best < 1 || options.best > 8) {
    throw std::invalid_argument("best is " + std::to_string(options.best) + ", expected 1 to 8");
  }
  if (!(options.ratio > 0.0 && options.ratio <= 1.0)) {
    throw std::invalid_argument("ratio is " + std::to_string(options.ratio) + ", expected above 0, at most 1");
  }
  if (!(options.most_distances > 0.0)) {
    throw std::invalid_argument("most_distances is " + std::to_string(options.most_distances) +
                                ", expected a number above 0");
  }
}

/// Number of descriptors; `cloud` for errors.
std::size_t count(std::span<const float> values, std::size_t length, const char* cloud) {
  if (length == 0 || values.size() % length != 0) {
    throw std::invalid_argument(std::string(cloud) + " has " + std::to_string(values.size()) +
                                " numbers, expected rows of " + std::to_string(length));
  }
  return values.size() / length;
}

double largest_norm(std::span<const float> values, std::size_t length) {
  double largest = 0.0;
  for (std::size_t i = 0; i < values.size(); i += length) {
    double squared = 0.0;
    for (const float value : values.subspan(i, length))
      squared += static_cast<double>(value) * static_cast<double>(value);
    if (!std::isfinite(squared)) {
      throw std::invalid_argument("descriptor " + std::to_string(i / length) + " is not finite");
    }
    largest = std::max(largest, squared);
  }
  return std::sqrt(largest);
}

/// The best matches of both sides. Which blocks the sources are cut into does not matter: lists are merged by distance,
/// then index.
void search(const FixedPointDescriptors& source, const FixedPointDescriptors& target, BestMatches& of_source,
            BestMatches& of_target) {
  constexpr std::size_t kSmallestBlock = 256;
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  // Few: each begins with empty lists of the targets, which take many entries until they are good.
  const std::size_t blocks = std::clamp<std::size_t>(source.size() / kSmallestBlock, 1, threads == 1 ? 1 : 2 * threads);
  if (blocks == 1) return best_matches(source, 0, source.size(), target, of_source, of_target);
  std::vector<BestMatches> parts;
  parts.reserve(blocks);
  for (std::size_t b = 0; b < blocks; ++b) parts.emplace_back(target.size(), of_target.k());
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    best_matches(source, source.size() * b / blocks, source.size() * (b + 1) / blocks, target, of_source, parts[b]);
  });
  for (const BestMatches& part : parts) of_target.merge(part);
}

bool is_among_best(const BestMatches& matches, std::size_t i, std::size_t best, std::uint32_t index) {
  for (std::size_t rank = 0; rank < best; ++rank) {
    if (matches.index(i, rank) == index) return true;
  }
  return false;
}

}  // namespace

std::vector<Match> match(std::span<const float> source, std::span<const float> target, std::size_t length,
                         const MatchOptions& options) {
  check(options);
  const std::size_t sources = count(source, length, "source");
  const std::size_t targets = count(target, length, "target");
  if (const double distances = static_cast<double>(sources) * static_cast<double>(targets);
      distances > options.most_distances) {
    throw std::invalid_argument(std::to_string(sources) + " descriptors against " + std::to_string(targets) +
                                ", which is above most_distances: choose fewer points");
  }
  if (sources == 0 || targets == 0) return {};
  const double unit =
      FixedPointDescriptors::unit_for(std::max(largest_norm(source, length), largest_norm(target, length)), length);
  const FixedPointDescriptors fixed_source(source, length, unit);
  const FixedPointDescriptors fixed_target(target, length, unit);
  // The ratio test asks for the second nearest.
  const std::size_t k = std::max<std::size_t>(options.best, options.ratio < 1.0 ? 2 : 1);
  BestMatches of_source(sources, k), of_target(targets, k);
  search(fixed_source, fixed_target, of_source, of_target);

  std::vector<Match> matches;
  const double squared_ratio = options.ratio * options.ratio;
  for (std::uint32_t i = 0; i < sources; ++i) {
    if (options.ratio < 1.0 && of_source.index(i, 1) != BestMatches::kNone &&
        !(of_source.squared_distance(i, 0) < squared_ratio * of_source.squared_distance(i, 1))) {
      continue;
    }
    for (std::size_t rank = 0; rank < options.best; ++rank) {
      const std::uint32_t j = of_source.index(i, rank);
      if (j == BestMatches::kNone) break;
      if (options.mutual && !is_among_best(of_target, j, options.best, i)) continue;
      const double distance = unit * std::sqrt(static_cast<double>(of_source.squared_distance(i, rank)));
      matches.push_back({i, j, static_cast<float>(distance)});
    }
  }
  return matches;
}

}  // namespace consimd::features
