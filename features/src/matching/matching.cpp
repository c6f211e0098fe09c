#include <consimd/features/matching.hpp>

#include <consimd/kernels/descriptor_matches.hpp>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <optional>
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

/// The best matches of both sides. Into how many parts the sources are cut does not matter: lists are merged by
/// distance, then number.
void search(const FixedPointDescriptors& source, const FixedPointDescriptors& target, BestMatches& of_source,
            BestMatches& of_target) {
  constexpr std::size_t kSmallestPart = 256;
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  // Parts take equally long. More of them than threads would only take longer, since each begins with lists of the
  // targets that rule nothing out yet: 4 parts take 1.2 times what one does, 16 parts 1.7 times.
  const std::size_t parts = std::clamp<std::size_t>(source.size() / kSmallestPart, 1, threads);
  if (parts == 1) return best_matches(source, target, of_source, of_target);
  std::vector<BestMatches> lists;
  lists.reserve(parts);
  for (std::size_t part = 0; part < parts; ++part) lists.emplace_back(target, of_target.k());
  tbb::parallel_for(std::size_t{0}, parts,
                    [&](std::size_t part) { best_matches(source, target, of_source, lists[part], part, parts); });
  for (const BestMatches& list : lists) of_target.merge(list);
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
  const FixedPointForm form(source, target, length);
  std::optional<FixedPointDescriptors> fixed_source, fixed_target;
  tbb::parallel_invoke([&] { fixed_source.emplace(source, form); }, [&] { fixed_target.emplace(target, form); });
  // The ratio test asks for the second nearest.
  const std::size_t k = std::max<std::size_t>(options.best, options.ratio < 1.0 ? 2 : 1);
  BestMatches of_source(*fixed_source, k), of_target(*fixed_target, k);
  search(*fixed_source, *fixed_target, of_source, of_target);

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
      const double distance = form.unit() * std::sqrt(static_cast<double>(of_source.squared_distance(i, rank)));
      matches.push_back({i, j, static_cast<float>(distance)});
    }
  }
  return matches;
}

}  // namespace consimd::features
