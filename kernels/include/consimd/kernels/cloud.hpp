// Structure-of-arrays storage of one point cloud.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

class Cloud;

/// What a kernel reads of a cloud: three arrays of `padded_size()` floats in the working frame of the owner (see
/// `Cloud`), 64-byte aligned, NaN from `size()` on, and as many of the normals where there are any. Only a `Cloud` can
/// make one. Valid while its owner lives and gets no other normals.
class CloudView {
 public:
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// At least size() + kBlock: a register that starts at any point lies inside.
  [[nodiscard]] std::size_t padded_size() const noexcept { return padded_; }
  /// Working-frame length of one unit of the caller's, a power of two.
  [[nodiscard]] double scale() const noexcept { return scale_; }
  /// Axis 0, 1 or 2 of the points.
  [[nodiscard]] const float* points(std::size_t axis) const noexcept { return points_ + axis * padded_; }
  [[nodiscard]] bool has_normals() const noexcept { return normals_ != nullptr; }
  /// Axis 0, 1 or 2 of the normals, which must be there.
  [[nodiscard]] const float* normals(std::size_t axis) const noexcept { return normals_ + axis * padded_; }

 private:
  friend class Cloud;
  CloudView(const float* points, const float* normals, std::size_t size, std::size_t padded, double scale) noexcept
      : points_(points), normals_(normals), size_(size), padded_(padded), scale_(scale) {}

  const float* points_;
  const float* normals_;
  std::size_t size_;
  std::size_t padded_;
  double scale_;
};

/// Owner of the points of one cloud, with normals or without.
///
/// The arrays hold the points in a working frame of their own, in single precision: p' = scale * (p - origin), computed
/// in double before rounding. `origin` is the mean of the points, `scale` the power of two that brings the largest
/// coordinate into [0.5, 1): map coordinates of 5e6 m cost no precision, and no unit overflows a power of a length.
class Cloud {
 public:
  Cloud() = default;

  /// Copies the points, but those without a place: of a coordinate that is not finite, or all three equal to `missing`,
  /// which depth cameras write where they saw nothing (0, say). Stray points are left out as well: up to a tenth of
  /// them that are more than 1024 times as far from the middle, coordinate by coordinate the median, as the median
  /// point. Throws std::invalid_argument where there are 2^32 - 1 points or more.
  explicit Cloud(PointSpan<double> points, std::optional<double> missing = std::nullopt);
  explicit Cloud(PointSpan<float> points, std::optional<double> missing = std::nullopt);

  /// Points given in the working frame of `frame`, three arrays of `size` finite floats, in that frame.
  [[nodiscard]] static Cloud in_frame_of(const Cloud& frame, const std::array<const float*, 3>& points,
                                         std::size_t size);

  /// The chosen points in the given order, with their normals, in the same frame. Throws std::out_of_range on a bad
  /// index.
  [[nodiscard]] Cloud subset(std::span<const std::uint32_t> rows) const;

  /// Gives each point a normal: three arrays of `size()` floats, unit vectors, or NaN where there is none.
  void set_normals(const std::array<const float*, 3>& normals);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] CloudView view() const noexcept { return {points_.get(), normals_.get(), size_, padded_, scale_}; }
  operator CloudView() const noexcept { return view(); }  // NOLINT(google-explicit-constructor)

  /// Point i in the caller's frame. i < size().
  [[nodiscard]] std::array<double, 3> point(std::size_t i) const noexcept;
  /// A point of the caller's frame in the working frame.
  [[nodiscard]] std::array<double, 3> to_working_frame(const std::array<double, 3>& point) const noexcept;

  [[nodiscard]] const std::array<double, 3>& origin() const noexcept { return origin_; }
  [[nodiscard]] double scale() const noexcept { return scale_; }
  /// Rows given to the constructor that have no place, or that are stray.
  [[nodiscard]] std::size_t left_out() const noexcept { return left_out_; }
  /// Which row given to the constructor became point i; i itself in a cloud made otherwise. i < size().
  [[nodiscard]] std::uint32_t input_row(std::size_t i) const noexcept {
    return input_rows_.empty() ? static_cast<std::uint32_t>(i) : input_rows_[i];
  }

 private:
  struct AlignedDelete {
    void operator()(float* p) const noexcept;
  };
  using Arrays = std::unique_ptr<float[], AlignedDelete>;

  /// Makes the mean of the points the origin; returns the largest distance from it along an axis.
  template <typename Points>
  double centre(const Points& points);
  template <typename T>
  void assign(const PointSpan<T>& points, std::optional<double> missing);
  void resize(std::size_t size);
  [[nodiscard]] Arrays allocate() const;

  Arrays points_;
  Arrays normals_;
  std::size_t size_ = 0;
  std::size_t padded_ = 0;
  std::size_t left_out_ = 0;
  double scale_ = 1.0;
  std::array<double, 3> origin_{};
  std::vector<std::uint32_t> input_rows_;  // empty: all of them
};

}  // namespace consimd
