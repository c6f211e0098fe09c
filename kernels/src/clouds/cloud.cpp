#include <consimd/kernels/cloud.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "../remoteness.hpp"
#include "../working_scale.hpp"

namespace consimd {
namespace {

constexpr std::align_val_t kAlignment{64};
constexpr float kPadding = std::numeric_limits<float>::quiet_NaN();

template <typename T>
bool has_place(const PointSpan<T>& points, std::size_t i, const std::optional<double>& missing) {
  const auto x = static_cast<double>(points(i, 0));
  const auto y = static_cast<double>(points(i, 1));
  const auto z = static_cast<double>(points(i, 2));
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) return false;
  return !missing || x != *missing || y != *missing || z != *missing;
}

}  // namespace

void Cloud::AlignedDelete::operator()(float* p) const noexcept { ::operator delete[](p, kAlignment); }

Cloud::Arrays Cloud::allocate() const {
  Arrays arrays(static_cast<float*>(::operator new[](3 * padded_ * sizeof(float), kAlignment)));
  for (std::size_t c = 0; c < 3; ++c) {
    std::fill(arrays.get() + c * padded_ + size_, arrays.get() + (c + 1) * padded_, kPadding);
  }
  return arrays;
}

void Cloud::resize(std::size_t size) {
  size_ = size;
  padded_ = (size + kBlock - 1) / kBlock * kBlock + kBlock;
  points_ = allocate();
}

template <typename Points>
double Cloud::centre(const Points& points) {
  // Terms are scaled before they are summed: a plain sum could overflow where the mean does not.
  const auto n = static_cast<double>(points.size);
  std::array<double, 3> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  origin_.fill(0.0);
  for (std::size_t i = 0; i < points.size; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto x = static_cast<double>(points(i, c));
      origin_[c] += x / n;
      low[c] = std::min(low[c], x);
      high[c] = std::max(high[c], x);
    }
  }
  double largest = 0.0;
  if (points.size > 0) {
    for (std::size_t c = 0; c < 3; ++c) largest = std::max({largest, high[c] - origin_[c], origin_[c] - low[c]});
  }
  return largest;
}

template <typename T>
void Cloud::assign(const PointSpan<T>& points, std::optional<double> missing) {
  if (points.size >= std::numeric_limits<std::uint32_t>::max()) {
    throw std::invalid_argument("a cloud of " + std::to_string(points.size) + " points, expected fewer than 2^32 - 1");
  }
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size; ++i) count += has_place(points, i, missing) ? 1u : 0u;
  left_out_ = points.size - count;
  if (left_out_ > 0) {
    input_rows_.reserve(count);
    for (std::size_t i = 0; i < points.size; ++i) {
      if (has_place(points, i, missing)) input_rows_.push_back(static_cast<std::uint32_t>(i));
    }
  }
  const auto chosen = [&] { return detail::ChosenPoints<T>{points, input_rows_, count}; };
  double largest = centre(chosen());
  if (const std::vector<double> remote = detail::remoteness(chosen(), largest); !remote.empty()) {
    std::vector<std::uint32_t> near;
    for (std::size_t i = 0; i < count; ++i) {
      if (remote[i] <= detail::kFarOfCloud) near.push_back(input_row(i));
    }
    count = near.size();
    left_out_ = points.size - count;
    input_rows_ = std::move(near);
    largest = centre(chosen());
  }
  scale_ = detail::working_scale(largest);
  resize(count);
  for (std::size_t c = 0; c < 3; ++c) {
    float* p = points_.get() + c * padded_;
    for (std::size_t i = 0; i < count; ++i) {
      p[i] = static_cast<float>((static_cast<double>(points(input_row(i), c)) - origin_[c]) * scale_);
    }
  }
}

Cloud::Cloud(PointSpan<double> points, std::optional<double> missing) { assign(points, missing); }
Cloud::Cloud(PointSpan<float> points, std::optional<double> missing) { assign(points, missing); }

Cloud Cloud::in_frame_of(const Cloud& frame, const std::array<const float*, 3>& points, std::size_t size) {
  Cloud cloud;
  cloud.scale_ = frame.scale_;
  cloud.origin_ = frame.origin_;
  cloud.resize(size);
  for (std::size_t c = 0; c < 3; ++c) std::copy_n(points[c], size, cloud.points_.get() + c * cloud.padded_);
  return cloud;
}

Cloud Cloud::subset(std::span<const std::uint32_t> rows) const {
  for (const std::uint32_t row : rows) {
    if (row < size_) continue;
    throw std::out_of_range("point " + std::to_string(row) + " of " + std::to_string(size_));
  }
  Cloud chosen;
  chosen.scale_ = scale_;
  chosen.origin_ = origin_;
  chosen.resize(rows.size());
  if (normals_) chosen.normals_ = chosen.allocate();
  for (std::size_t c = 0; c < 3; ++c) {
    const auto choose = [&](const Arrays& from, const Arrays& to) {
      std::transform(rows.begin(), rows.end(), to.get() + c * chosen.padded_,
                     [all = from.get() + c * padded_](std::uint32_t row) { return all[row]; });
    };
    choose(points_, chosen.points_);
    if (normals_) choose(normals_, chosen.normals_);
  }
  return chosen;
}

void Cloud::set_normals(const std::array<const float*, 3>& normals) {
  Arrays arrays = allocate();
  for (std::size_t c = 0; c < 3; ++c) std::copy_n(normals[c], size_, arrays.get() + c * padded_);
  normals_ = std::move(arrays);
}

std::array<double, 3> Cloud::point(std::size_t i) const noexcept {
  std::array<double, 3> p{};
  for (std::size_t c = 0; c < 3; ++c) {
    p[c] = origin_[c] + static_cast<double>(points_[c * padded_ + i]) / scale_;
  }
  return p;
}

std::array<double, 3> Cloud::to_working_frame(const std::array<double, 3>& point) const noexcept {
  std::array<double, 3> p{};
  for (std::size_t c = 0; c < 3; ++c) p[c] = (point[c] - origin_[c]) * scale_;
  return p;
}

}  // namespace consimd
