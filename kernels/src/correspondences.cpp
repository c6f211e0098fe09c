#include <consimd/kernels/correspondences.hpp>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string>

#include "kernel_arguments.hpp"
#include "remoteness.hpp"
#include "working_scale.hpp"

namespace consimd {
namespace {

constexpr std::align_val_t kAlignment{64};
constexpr float kPadding = std::numeric_limits<float>::quiet_NaN();

template <typename T>
void require_finite(const PointSpan<T>& points, const char* cloud) {
  for (std::size_t i = 0; i < points.size; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (std::isfinite(points(i, c))) continue;
      throw std::invalid_argument(std::string(cloud) + " point " + std::to_string(i) + ": coordinate " + "xyz"[c] +
                                  " is " + std::to_string(points(i, c)) + ", expected a finite number");
    }
  }
}

/// Mean of the points that `counts`, `n` of them, by scaled terms: a plain sum could overflow where the mean does not.
template <typename T, typename Counts>
std::array<double, 3> centroid(const PointSpan<T>& points, std::size_t n, const Counts& counts) {
  std::array<double, 3> mean{};
  for (std::size_t i = 0; i < points.size; ++i) {
    if (!counts(i)) continue;
    for (std::size_t c = 0; c < 3; ++c) mean[c] += static_cast<double>(points(i, c)) / static_cast<double>(n);
  }
  return mean;
}

template <typename T, typename Counts>
double largest_offset(const PointSpan<T>& points, const std::array<double, 3>& origin, const Counts& counts) {
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size; ++i) {
    if (!counts(i)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      largest = std::max(largest, std::abs(static_cast<double>(points(i, c)) - origin[c]));
    }
  }
  return largest;
}

/// Residuals in the working frame are rounded by a quarter of this, a little more or less.
constexpr double kResolution = 0x1p-20;

/// The noise that points about `centroid` with offsets up to `extent` are rounded by, in the frame and before, as T.
template <typename T>
double rounding(const std::array<double, 3>& centroid, double extent, double frame_scale) {
  const double offset = std::max({std::abs(centroid[0]), std::abs(centroid[1]), std::abs(centroid[2])});
  return std::max(extent == 0.0 ? 0.0 : kResolution / frame_scale,
                  static_cast<double>(std::numeric_limits<T>::epsilon()) * (offset + extent));
}

void require_rows(std::span<const std::uint32_t> rows, std::size_t size) {
  // The largest first, which vectorises: loops that gather subsets spend much of their time here.
  std::uint32_t largest = 0;
  for (const std::uint32_t row : rows) largest = std::max(largest, row);
  if (rows.empty() || largest < size) return;
  throw std::out_of_range("row " + std::to_string(largest) + " of " + std::to_string(size) + " correspondences");
}

}  // namespace

void Correspondences::AlignedDelete::operator()(float* p) const noexcept { ::operator delete[](p, kAlignment); }

void Correspondences::allocate(std::size_t size) {
  size_ = size;
  padded_ = (size + kBlock - 1) / kBlock * kBlock;
  if (padded_ > capacity_) {
    data_.reset(static_cast<float*>(::operator new[](6 * padded_ * sizeof(float), kAlignment)));
    capacity_ = padded_;
  }
  for (std::size_t row = 0; row < 6; ++row) {
    std::fill(data_.get() + row * padded_ + size_, data_.get() + (row + 1) * padded_, kPadding);
  }
}

template <typename T>
void Correspondences::assign(PointSpan<T> source, PointSpan<T> target) {
  if (source.size != target.size) {
    throw std::invalid_argument("correspondences need as many source as target points, got " +
                                std::to_string(source.size) + " and " + std::to_string(target.size));
  }
  require_finite(source, "source");
  require_finite(target, "target");
  const auto all = [](std::size_t) { return true; };
  source_centroid_ = centroid(source, source.size, all);
  target_centroid_ = centroid(target, target.size, all);
  double source_extent = largest_offset(source, source_centroid_, all);
  double target_extent = largest_offset(target, target_centroid_, all);
  double extent = std::max(source_extent, target_extent);
  far_rows_.clear();
  if (const std::vector<double> remote = detail::remoteness(source, source_extent, target, target_extent);
      !remote.empty()) {
    const auto in_bulk = [&](std::size_t i) { return remote[i] <= detail::kBulk; };
    const auto near = [&](std::size_t i) { return remote[i] <= detail::kFar; };
    const auto bulk = static_cast<std::size_t>(
        std::ranges::count_if(remote, [](double distance) { return distance <= detail::kBulk; }));
    source_centroid_ = centroid(source, bulk, in_bulk);
    target_centroid_ = centroid(target, bulk, in_bulk);
    source_extent = largest_offset(source, source_centroid_, in_bulk);
    target_extent = largest_offset(target, target_centroid_, in_bulk);
    extent = std::max(largest_offset(source, source_centroid_, near), largest_offset(target, target_centroid_, near));
    for (std::uint32_t i = 0; i < source.size; ++i) {
      if (!near(i)) far_rows_.push_back(i);
    }
  }
  scale_ = detail::working_scale(extent);
  const double bulk_scale = detail::working_scale(std::max(source_extent, target_extent));
  resolution_ = std::max(rounding<T>(source_centroid_, source_extent, bulk_scale),
                         rounding<T>(target_centroid_, target_extent, bulk_scale));

  allocate(source.size);
  for (std::size_t c = 0; c < 3; ++c) {
    float* p = data_.get() + c * padded_;
    float* q = data_.get() + (3 + c) * padded_;
    for (std::size_t i = 0; i < size_; ++i) {
      p[i] = static_cast<float>((static_cast<double>(source(i, c)) - source_centroid_[c]) * scale_);
      q[i] = static_cast<float>((static_cast<double>(target(i, c)) - target_centroid_[c]) * scale_);
    }
  }
  blank_far_rows();
}

void Correspondences::set_source_viewpoint(const std::array<double, 3>& viewpoint) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::isfinite(viewpoint[c])) continue;
    throw std::invalid_argument(std::string("source_viewpoint: coordinate ") + "xyz"[c] + " is " +
                                std::to_string(viewpoint[c]) + ", expected a finite number");
  }
  source_viewpoint_ = viewpoint;
}

void Correspondences::blank_far_rows() {
  for (const std::uint32_t row : far_rows_) {
    for (std::size_t c = 0; c < 6; ++c) data_[c * padded_ + row] = kPadding;
  }
}

std::vector<std::uint32_t> Correspondences::near_rows() const {
  std::vector<std::uint32_t> rows;
  rows.reserve(size_ - far_rows_.size());
  auto far = far_rows_.begin();
  for (std::uint32_t row = 0; row < size_; ++row) {
    if (far != far_rows_.end() && *far == row) {
      ++far;
    } else {
      rows.push_back(row);
    }
  }
  return rows;
}

Correspondences::Correspondences(PointSpan<double> source, PointSpan<double> target) { assign(source, target); }
Correspondences::Correspondences(PointSpan<float> source, PointSpan<float> target) { assign(source, target); }

Correspondences Correspondences::subset(std::span<const std::uint32_t> rows) const {
  Correspondences chosen;
  chosen.assign_subset(*this, rows);
  return chosen;
}

Correspondences Correspondences::with_scaled_source(double factor) const {
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    throw std::invalid_argument("factor is " + std::to_string(factor) + ", expected a finite number above 0");
  }
  double largest = 0.0;
  for (std::size_t c = 0; c < 6; ++c) {
    const double of_cloud = c < 3 ? factor : 1.0;
    for (std::size_t i = 0; i < size_; ++i) {
      largest = std::max(largest, of_cloud * std::abs(static_cast<double>(data_[c * padded_ + i])));
    }
  }
  Correspondences scaled;
  scaled.source_centroid_ = source_centroid_;
  scaled.source_viewpoint_ = source_viewpoint_;
  for (double& x : scaled.source_centroid_) x *= factor;
  for (double& x : scaled.source_viewpoint_) x *= factor;
  scaled.resolution_ = std::max(1.0, factor) * resolution_;
  scaled.far_rows_ = far_rows_;
  scaled.target_centroid_ = target_centroid_;
  scaled.scale_ = detail::working_scale(largest / scale_);
  scaled.allocate(size_);
  const double resized = scaled.scale_ / scale_;
  for (std::size_t c = 0; c < 6; ++c) {
    const double of_cloud = c < 3 ? resized * factor : resized;
    std::transform(data_.get() + c * padded_, data_.get() + c * padded_ + size_, scaled.data_.get() + c * padded_,
                   [of_cloud](float x) { return static_cast<float>(static_cast<double>(x) * of_cloud); });
  }
  return scaled;
}

void Correspondences::assign_subset(const Correspondences& parent, std::span<const std::uint32_t> rows) {
  assign_pairs(parent, rows, rows);
}

void Correspondences::assign_pairs(const Correspondences& parent, std::span<const std::uint32_t> source_rows,
                                   std::span<const std::uint32_t> target_rows) {
  detail::require_size("target_rows", target_rows.size(), source_rows.size());
  require_rows(source_rows, parent.size_);
  if (target_rows.data() != source_rows.data()) require_rows(target_rows, parent.size_);
  scale_ = parent.scale_;
  source_centroid_ = parent.source_centroid_;
  source_viewpoint_ = parent.source_viewpoint_;
  target_centroid_ = parent.target_centroid_;
  resolution_ = parent.resolution_;
  far_rows_.clear();
  allocate(source_rows.size());
  for (std::size_t c = 0; c < 6; ++c) {
    const auto& rows = c < 3 ? source_rows : target_rows;
    const float* from = parent.data_.get() + c * parent.padded_;
    std::transform(rows.begin(), rows.end(), data_.get() + c * padded_,
                   [from](std::uint32_t row) { return from[row]; });
  }
  if (parent.far_rows_.empty()) return;
  for (std::uint32_t row = 0; row < size_; ++row) {
    if (std::isnan(data_[row]) || std::isnan(data_[3 * padded_ + row])) far_rows_.push_back(row);
  }
  blank_far_rows();
}

}  // namespace consimd
