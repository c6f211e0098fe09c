#include "problem_kinds.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <consimd/studies/case_folder.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>
#include <consimd/synth/problem_files.hpp>

namespace consimd::bench {
namespace {

using synth::HardProblemOptions;
using synth::OutlierModel;
using synth::Scene;

struct SyntheticKind {
  const char* name;
  HardProblemOptions options;
};

// Extents and noise are those of scans: metres.
const SyntheticKind kSynthetic[] = {
    {"uniform", {.sigma = 1.0, .half_extent = 100.0}},
    {"permuted on a plane",
     {.sigma = 0.3, .half_extent = 50.0, .scene = Scene::planar, .outliers = OutlierModel::permuted}},
    {"many to many", {.sigma = 0.3, .half_extent = 50.0, .outliers = OutlierModel::many_to_many}},
    {"one to many", {.sigma = 0.05, .half_extent = 5.0, .scene = Scene::room, .outliers = OutlierModel::one_to_many}},
    {"3 clusters of 6 m",
     {.sigma = 1.0, .half_extent = 100.0, .outliers = OutlierModel::clustered, .clusters = 3, .cluster_sigma = 6.0}},
    {"5 clusters of 4 m",
     {.sigma = 1.0, .half_extent = 100.0, .outliers = OutlierModel::clustered, .clusters = 5, .cluster_sigma = 4.0}},
    {"10 clusters of 2 m",
     {.sigma = 1.0, .half_extent = 100.0, .outliers = OutlierModel::clustered, .clusters = 10, .cluster_sigma = 2.0}},
    {"40 clusters of 1.5 m",
     {.sigma = 0.5, .half_extent = 100.0, .outliers = OutlierModel::clustered, .clusters = 40, .cluster_sigma = 1.5}},
    {"kept range", {.sigma = 0.3, .half_extent = 40.0, .outliers = OutlierModel::alike}},
    {"planes", {.sigma = 0.3, .half_extent = 50.0, .scene = Scene::planar, .outliers = OutlierModel::alike}},
    {"rings",
     {.sigma = 0.15, .half_extent = 90.0, .scene = Scene::rings, .parts = 32, .outliers = OutlierModel::alike}},
    {"poles",
     {.sigma = 0.15, .half_extent = 40.0, .scene = Scene::poles, .parts = 20, .outliers = OutlierModel::alike}},
    {"lines",
     {.sigma = 0.15, .half_extent = 30.0, .scene = Scene::lines, .parts = 15, .outliers = OutlierModel::alike}},
    {"corridor", {.sigma = 0.1, .half_extent = 30.0, .scene = Scene::corridor, .outliers = OutlierModel::alike}},
    {"room", {.sigma = 0.08, .half_extent = 5.0, .scene = Scene::room, .outliers = OutlierModel::alike}},
    {"facade",
     {.sigma = 0.07, .half_extent = 25.0, .scene = Scene::facade, .parts = 16, .outliers = OutlierModel::alike}},
    {"grid", {.sigma = 0.1, .half_extent = 9.0, .scene = Scene::grid, .parts = 6, .outliers = OutlierModel::alike}},
};

using Point = Eigen::Vector3d;

// Both clouds of a recorded pair, row by row, without what its true pose explains nearly.
struct Pair {
  std::vector<Point> source;
  std::vector<Point> target;
  double noise_bound = 0.0;
};

// In noise bounds: rows that the true pose misses by less are left out.
constexpr double kBeyond = 10.0;

Pair outliers_of(const std::filesystem::path& folder) {
  const studies::CaseFile file = studies::read_case_file(folder / "case.json");
  const synth::Problem problem =
      synth::read_problem(folder / "correspondences.txt", folder / "pose.txt", file.noise_bound);
  Pair pair;
  pair.noise_bound = file.noise_bound;
  for (std::size_t row = 0; row < problem.size(); ++row) {
    const Point p = Eigen::Map<const Point>(problem.source.data() + 3 * row);
    const Point q = Eigen::Map<const Point>(problem.target.data() + 3 * row);
    if ((problem.T_target_source * p - q).norm() < kBeyond * file.noise_bound) continue;
    pair.source.push_back(p);
    pair.target.push_back(q);
  }
  return pair;
}

// The same draws with every standard library.
class Draws {
 public:
  Draws(std::uint64_t seed, std::uint64_t trial) : engine_(seed * 1'000'003 + trial) {}

  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }

  template <typename Iterator>
  void shuffle(Iterator begin, Iterator end) {
    for (auto left = end - begin; left > 1; --left) {
      std::swap(begin[left - 1], begin[static_cast<std::ptrdiff_t>(below(static_cast<std::size_t>(left)))]);
    }
  }

  // So many of the rows below `size`, or all of them, in random order.
  std::vector<std::size_t> rows(std::size_t size, std::size_t most) {
    std::vector<std::size_t> result(size);
    std::iota(result.begin(), result.end(), std::size_t{0});
    shuffle(result.begin(), result.end());
    result.resize(std::min(size, most));
    return result;
  }

 private:
  std::mt19937_64 engine_;
};

NoPose matched(const std::vector<Point>& source, const std::vector<Point>& target, double noise_bound) {
  return {Correspondences(PointSpan<double>::interleaved(source.front().data(), source.size()),
                          PointSpan<double>::interleaved(target.front().data(), target.size())),
          noise_bound};
}

std::vector<Point> chosen(const std::vector<Point>& points, const std::vector<std::size_t>& rows) {
  std::vector<Point> result;
  result.reserve(rows.size());
  for (const std::size_t row : rows) result.push_back(points[row]);
  return result;
}

// Puts rows whose sources lie together side by side, halving them at the middle of their longest side.
constexpr std::ptrdiff_t kTogether = 32;
using Rows = std::vector<std::size_t>;
void gather(Rows::iterator begin, Rows::iterator end, const std::vector<Point>& source) {
  if (end - begin <= kTogether) return;
  Eigen::AlignedBox3d box;
  for (auto row = begin; row != end; ++row) box.extend(source[*row]);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto half = begin + (end - begin) / 2;
  std::nth_element(begin, half, end, [&](std::size_t a, std::size_t b) {
    return std::pair(source[a][axis], a) < std::pair(source[b][axis], b);
  });
  gather(begin, half, source);
  gather(half, end, source);
}

NoPose exchanged(const Pair& pair, std::size_t rows, std::ptrdiff_t together, Draws draws) {
  Rows from = draws.rows(pair.source.size(), rows);
  std::sort(from.begin(), from.end());
  gather(from.begin(), from.end(), pair.source);
  Rows to = from;
  const auto size = static_cast<std::ptrdiff_t>(to.size());
  for (std::ptrdiff_t begin = 0; begin < size; begin += together) {
    draws.shuffle(to.begin() + begin, to.begin() + std::min(size, begin + together));
  }
  return matched(chosen(pair.source, from), chosen(pair.target, to), pair.noise_bound);
}

}  // namespace

std::vector<ProblemKind> synthetic_kinds(std::uint64_t seed) {
  std::vector<ProblemKind> kinds;
  for (const SyntheticKind& kind : kSynthetic) {
    kinds.push_back({kind.name, [&kind, seed](std::size_t rows, std::uint64_t trial) -> NoPose {
                       HardProblemOptions options = kind.options;
                       options.correspondences = rows;
                       options.outlier_ratio = 1.0;
                       options.seed = seed;
                       options.trial = trial;
                       const synth::Problem problem = synth::hard_problem(options);
                       return {problem.correspondences(), synth::noise_study_bound(problem.sigma)};
                     }});
  }
  return kinds;
}

std::vector<std::filesystem::path> case_folders(const std::filesystem::path& data) {
  std::vector<std::filesystem::path> folders;
  for (const char* const set : {"correspondences", "hard_pairs"}) {
    if (!std::filesystem::exists(data / set)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(data / set)) {
      if (std::filesystem::exists(entry.path() / "pose.txt")) folders.push_back(entry.path());
    }
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

std::vector<ProblemKind> recorded_kinds(const std::vector<std::filesystem::path>& folders, std::uint64_t seed) {
  const auto pairs = std::make_shared<std::vector<Pair>>();
  for (const std::filesystem::path& folder : folders) {
    Pair pair = outliers_of(folder);
    if (pair.source.size() >= 3) pairs->push_back(std::move(pair));
  }
  std::vector<ProblemKind> kinds;
  if (pairs->empty()) return kinds;
  const auto pair_of = [pairs](std::uint64_t trial) -> const Pair& { return (*pairs)[trial % pairs->size()]; };
  kinds.push_back({"recorded, exchanged", [=](std::size_t rows, std::uint64_t trial) {
                     const Pair& pair = pair_of(trial);
                     return exchanged(pair, rows, static_cast<std::ptrdiff_t>(pair.source.size()), {seed, trial});
                   }});
  kinds.push_back({"recorded, exchanged nearby", [=](std::size_t rows, std::uint64_t trial) {
                     return exchanged(pair_of(trial), rows, kTogether, {seed, trial});
                   }});
  if (pairs->size() < 2) return kinds;
  kinds.push_back({"of two recorded pairs", [=](std::size_t rows, std::uint64_t trial) {
                     Draws draws(seed, trial);
                     const Pair& one = pair_of(trial);
                     const Pair& other = pair_of(trial + 1 + draws.below(pairs->size() - 1));
                     const std::size_t size = std::min({rows, one.source.size(), other.target.size()});
                     return matched(chosen(one.source, draws.rows(one.source.size(), size)),
                                    chosen(other.target, draws.rows(other.target.size(), size)),
                                    std::max(one.noise_bound, other.noise_bound));
                   }});
  return kinds;
}

}  // namespace consimd::bench
