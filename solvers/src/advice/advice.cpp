#include <consimd/solvers/advice.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <locale>
#include <optional>
#include <sstream>

#include <consimd/solvers/pcr99.hpp>

#include "noise_bound/bound_search.hpp"

namespace consimd {
namespace {

// Rows up to which it is likely that somebody has looked at each of them.
constexpr std::size_t kFewRows = 30;
// A scale that differs from 1 by less than this many deviations is 1, and so is one closer than this share.
constexpr double kDeviations = 5.0;
constexpr double kLeastDifference = 1e-3;

// Rows that a scale is searched among at a noise bound that was given: the search looks at all pairs, a fifth of a
// second on one core. A twentieth of them right is enough for it.
constexpr std::size_t kScaleRows = 1024;
// Triples of the best-ranked rows that are looked at: those of a scale that is there are among the first of them.
constexpr std::uint64_t kTriples = 20'000'000;
// And where none was given, at each of these shares of the target's extent: the bound that ends a search in vain tells
// nothing, and is far from any noise where the clouds differ in size.
constexpr std::size_t kScaleRowsWithoutBound = 512;
constexpr std::array kShares{1.0 / 16.0, 1.0 / 128.0, 1.0 / 1024.0};

Correspondences some_rows(const Correspondences& correspondences, std::size_t most) {
  const std::vector<std::uint32_t> near = correspondences.near_rows();
  const std::size_t wanted = std::min(near.size(), most);
  std::vector<std::uint32_t> rows(wanted);
  for (std::size_t k = 0; k < wanted; ++k) rows[k] = near[k * near.size() / wanted];
  return correspondences.subset(rows);
}

// Median distance of the targets from their centroid, caller's unit.
double target_extent(const Correspondences& correspondences) {
  const CorrespondenceView view = correspondences.view();
  std::vector<double> distances(view.size());
  for (std::size_t k = 0; k < view.size(); ++k) {
    double square = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) square += double{view.target(axis)[k]} * double{view.target(axis)[k]};
    distances[k] = std::sqrt(square);
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  return *middle / view.scale();
}

// The scale that pair lengths agree on, where it is another than 1.
std::optional<double> other_scale(const Correspondences& correspondences, const Registration& result) {
  const bool bound_is_given = result.stages.empty() || result.stages.front().name != detail::kNoiseBoundStage;
  const Correspondences some = some_rows(correspondences, bound_is_given ? kScaleRows : kScaleRowsWithoutBound);
  if (some.size() < 3) return std::nullopt;
  const double extent = target_extent(some);
  std::vector<double> bounds;
  if (bound_is_given) bounds.push_back(result.noise_bound);
  // A bound as large as the target, in the unit of the source perhaps, tells nothing either.
  if (!bound_is_given || result.noise_bound > extent) {
    for (const double share : kShares) bounds.push_back(share * extent);
  }
  for (const double bound : bounds) {
    if (!(bound > 0.0)) continue;
    const Registration scaled = register_pcr99(
        some, {.noise_bound = bound, .seed = result.seed, .estimate_scale = true, .max_triples = kTriples});
    const double least = std::max(kDeviations * scaled.scale_deviation, kLeastDifference);
    if (scaled.has_pose() && std::abs(scaled.scale - 1.0) > least) return scaled.scale;
  }
  return std::nullopt;
}

template <typename... Parts>
std::string sentence(const Parts&... parts) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(4);
  (text << ... << parts);
  return text.str();
}

std::string of_other_scale(double scale) {
  return sentence("pair lengths agree on a scale of ", scale, ": see estimate_scale");
}

constexpr const char* kMirrored =
    "a mirror image fits: the rows agree on a reflection, as when an axis of one cloud is reversed or left-handed";

}  // namespace

std::vector<std::string> advice(const AssumedInliers& result) {
  std::vector<std::string> sentences;
  const bool told = result.other_scale || result.registration.mirrored || result.odd_row;
  if (result.geometry == PointGeometry::contradictory) {
    if (!told)
      sentences.emplace_back(
          "no motion fits the rows, whose residuals are as large as the clouds: rows are wrong, or in another order");
  } else if (result.geometry != PointGeometry::determined) {
    sentences.push_back(sentence("the points of a cloud are ", to_string(result.geometry),
                                 ", up to the residuals of a fit: they leave a rotation free, or a row is wrong"));
  }
  if (result.other_scale) sentences.push_back(of_other_scale(*result.other_scale));
  if (result.registration.mirrored) sentences.emplace_back(kMirrored);
  if (result.odd_row) {
    sentences.push_back(sentence("row ", *result.odd_row,
                                 " (from 0) is likely wrong: without it less than a tenth of the "
                                 "residuals' deviation would be left"));
  }
  return sentences;
}

std::vector<std::string> advice(const Correspondences& correspondences, const Registration& result) {
  std::vector<std::string> sentences;
  const auto far = correspondences.far_rows();
  if (!far.empty()) {
    sentences.push_back(sentence(far.size(), far.size() == 1 ? " row lies" : " rows lie", " far from all others and ",
                                 far.size() == 1 ? "counts as an outlier" : "count as outliers", ": row ", far.front(),
                                 far.size() == 1 ? "" : " is the first", " (from 0)"));
  }
  if (result.noise_bound > result.noise_bound_asked) {
    sentences.push_back(sentence("noise bound ", result.noise_bound_asked,
                                 " is below what the coordinates resolve: ", result.noise_bound, " was used"));
  }
  if (result.has_pose()) return sentences;
  if (result.mirrored) {
    sentences.emplace_back(kMirrored);
    return sentences;
  }
  if (result.scale == 1.0) {
    if (const std::optional<double> scale = other_scale(correspondences, result)) {
      sentences.push_back(of_other_scale(*scale));
      return sentences;
    }
  }
  if (result.status != Status::no_consensus && result.status != Status::too_few_correspondences) return sentences;
  if (correspondences.size() <= kFewRows) {
    sentences.push_back(sentence(correspondences.size(), correspondences.size() == 1 ? " row gives" : " rows give",
                                 " too little evidence to tell a pose from chance",
                                 correspondences.size() >= 3
                                     ? ": if all of them are known to be right, use assume_inliers"
                                     : ", and a pose needs three"));
  }
  return sentences;
}

}  // namespace consimd
