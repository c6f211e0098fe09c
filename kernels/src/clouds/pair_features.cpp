#include <consimd/kernels/pair_features.hpp>

#include "../dispatch.hpp"
#include "../kernel_arguments.hpp"
#include "cloud_arguments.hpp"

namespace consimd {

void pair_feature_counts(const CloudView& cloud, std::uint32_t point, std::span<const std::uint32_t> indices,
                         std::span<std::uint32_t, kPairFeatureBins> counts) {
  if (!cloud.has_normals()) throw std::invalid_argument("the cloud has no normals");
  detail::require_points(std::span(&point, 1), cloud.size());
  detail::require_points(indices, cloud.size());
  detail::active_table().clouds.pair_feature_counts(detail::raw_points(cloud), point, indices.data(), indices.size(),
                                                    counts.data());
}

void weighted_histogram_sum(std::span<const float> histograms, std::span<const std::uint32_t> rows,
                            std::span<const float> squared_distances, std::span<float, kHistogramStride> sum) {
  detail::require_size("squared_distances", squared_distances.size(), rows.size());
  detail::require_size("histograms", histograms.size(), histograms.size() / kHistogramStride * kHistogramStride);
  detail::require_points(rows, histograms.size() / kHistogramStride);
  detail::require_aligned("histograms", histograms.data());
  detail::require_aligned("sum", sum.data());
  detail::active_table().clouds.weighted_histogram_sum(histograms.data(), rows.data(), squared_distances.data(),
                                                       rows.size(), sum.data());
}

}  // namespace consimd
