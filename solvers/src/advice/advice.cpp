#include <consimd/solvers/advice.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <locale>
#include <sstream>

#include <consimd/solvers/pcr99.hpp>

namespace consimd {
namespace {

// Rows up to which it is likely that somebody has looked at each of them.
constexpr std::size_t kFewRows = 30;
// A scale that differs from 1 by less than this many deviations is 1, and so is one closer than this share.
constexpr double kDeviations = 5.0;
constexpr double kLeastDifference = 1e-3;

// Rows that a scale is searched among: the search looks at all pairs, a fifth of a second on one core. A twentieth of
// them right is enough for it.
constexpr std::size_t kScaleRows = 1024;

Correspondences some_rows(const Correspondences& correspondences) {
  const std::vector<std::uint32_t> near = correspondences.near_rows();
  const std::size_t wanted = std::min(near.size(), kScaleRows);
  std::vector<std::uint32_t> rows(wanted);
  for (std::size_t k = 0; k < wanted; ++k) rows[k] = near[k * near.size() / wanted];
  return correspondences.subset(rows);
}

template <typename... Parts>
std::string sentence(const Parts&... parts) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(4);
  (text << ... << parts);
  return text.str();
}

}  // namespace

std::vector<std::string> advice(const Correspondences& correspondences, const Registration& result) {
  std::vector<std::string> sentences;
  const auto far = correspondences.far_rows();
  if (!far.empty()) {
    sentences.push_back(sentence(far.size(), far.size() == 1 ? " row lies" : " rows lie",
                                 " far from all others and count as outliers: row ", far.front(),
                                 far.size() == 1 ? "" : " is the first", " (from 0)"));
  }
  if (result.noise_bound > result.noise_bound_asked) {
    sentences.push_back(sentence("noise bound ", result.noise_bound_asked,
                                 " is below what the coordinates resolve: ", result.noise_bound, " was used"));
  }
  if (result.has_pose()) return sentences;
  if (result.mirrored) {
    sentences.emplace_back(
        "a mirror image fits: the rows agree on a reflection, as when an axis of one cloud is reversed or left-handed");
    return sentences;
  }
  if (result.status != Status::no_consensus && result.status != Status::too_few_correspondences) return sentences;
  if (result.scale == 1.0 && correspondences.size() >= 3) {
    const Registration scaled = register_pcr99(
        some_rows(correspondences), {.noise_bound = result.noise_bound, .seed = result.seed, .estimate_scale = true});
    if (scaled.has_pose() &&
        std::abs(scaled.scale - 1.0) > std::max(kDeviations * scaled.scale_deviation, kLeastDifference)) {
      sentences.push_back(sentence("pair lengths agree on a scale of ", scaled.scale, ": see estimate_scale"));
      return sentences;
    }
  }
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
