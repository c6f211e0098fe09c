// Structure-of-arrays storage of putative correspondences between two point clouds.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Lanes that every array of a `Correspondences` is padded to a multiple of; one 64-bit word of consensus bits.
inline constexpr std::size_t kBlock = 64;

/// Borrowed points in any regular layout: coordinate c of point i is `data[i * point_stride + c * coordinate_stride]`.
template <typename T>
struct PointSpan {
  const T* data = nullptr;
  std::size_t size = 0;                  ///< number of points
  std::ptrdiff_t point_stride = 3;       ///< elements between two points
  std::ptrdiff_t coordinate_stride = 1;  ///< elements between x and y of one point

  /// x0 y0 z0 x1 y1 z1 ...: a row-major N x 3 array, or a column-major 3 x N one (Eigen's default).
  static PointSpan interleaved(const T* data, std::size_t size) { return {data, size, 3, 1}; }
  /// x0 x1 ... y0 y1 ... z0 z1 ...: a row-major 3 x N array, or a column-major N x 3 one.
  static PointSpan planar(const T* data, std::size_t size) {
    return {data, size, 1, static_cast<std::ptrdiff_t>(size)};
  }

  T operator()(std::size_t i, std::size_t c) const {
    return data[static_cast<std::ptrdiff_t>(i) * point_stride + static_cast<std::ptrdiff_t>(c) * coordinate_stride];
  }
};

class Correspondences;

/// What a kernel reads: six arrays of `padded_size()` floats, 64-byte aligned, in the working frame of the owner
/// (see `Correspondences`). Lanes from `size()` on, and those of far rows, are NaN, so every ordered comparison with
/// them is false.
/// Only a `Correspondences` can make one, so alignment and padding hold by construction. Valid while its owner lives.
class CorrespondenceView {
 public:
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t padded_size() const noexcept { return padded_; }
  /// 64-bit words that a set of consensus bits over these correspondences takes.
  [[nodiscard]] std::size_t words() const noexcept { return padded_ / kBlock; }
  /// Working-frame length of one unit of the caller's, a power of two.
  [[nodiscard]] double scale() const noexcept { return scale_; }
  /// Axis 0, 1 or 2 of the source and target points.
  [[nodiscard]] const float* source(std::size_t axis) const noexcept { return data_ + axis * stride_; }
  [[nodiscard]] const float* target(std::size_t axis) const noexcept { return data_ + (3 + axis) * stride_; }

  /// Rows `first` to `first + count - 1`, as far as there are; both are multiples of kBlock, `first` below `size()`.
  [[nodiscard]] CorrespondenceView rows(std::size_t first, std::size_t count) const noexcept {
    CorrespondenceView part = *this;
    part.data_ += first;
    part.size_ = std::min(count, size_ - first);
    part.padded_ = std::min(count, padded_ - first);
    return part;
  }

 private:
  friend class Correspondences;
  CorrespondenceView(const float* data, std::size_t size, std::size_t padded, double scale) noexcept
      : data_(data), size_(size), padded_(padded), stride_(padded), scale_(scale) {}

  const float* data_;
  std::size_t size_;
  std::size_t padded_;
  std::size_t stride_;  // between two of the six arrays
  double scale_;
};

/// Owner of N correspondences c_k = (p_k, q_k), p in the source and q in the target cloud.
///
/// The arrays hold the points in a working frame of their own, in single precision:
///   p' = scale * (p - source_centroid),  q' = scale * (q - target_centroid),
/// computed in double before rounding. `scale` is one power of two for both clouds that brings the largest
/// coordinate into [0.5, 1): map coordinates of 5e6 m cost no precision, and no unit (millimetres, kilometres) can
/// overflow a power of a length in a kernel. Kernels take lengths (noise bounds) in the caller's unit and poses in the
/// working frame; a length below 1e-9 of the working frame, finer than single precision resolves, counts as 1e-9, one
/// above 16 as 16.
///
/// A row with a point far from all others (a map coordinate left in, "no value" as -9999 or 1e308) takes no part in the
/// frame. Far from the middle of a cloud, its median coordinate by coordinate, are rows at more than 256 times the
/// median distance from it, which no pose that fits the others brings together: they keep their index and are NaN in
/// all six arrays, so that no kernel finds them consistent with anything. Rows at more than 32 times that distance are
/// left out of the centroids only. So the bulk of the data has the precision it had without them, as long as they are
/// the minority. Where no row is beyond 32, which is the case in ordinary data, nothing of this applies.
class Correspondences {
 public:
  Correspondences() = default;

  /// Copies `source[k]`, `target[k]`. Throws std::invalid_argument if the sizes differ, or at a coordinate that is not
  /// finite, naming its row and axis.
  Correspondences(PointSpan<double> source, PointSpan<double> target);
  Correspondences(PointSpan<float> source, PointSpan<float> target);

  /// The chosen rows, in the given order and in the same working frame. Throws std::out_of_range on a bad index.
  [[nodiscard]] Correspondences subset(std::span<const std::uint32_t> rows) const;

  /// Makes this the chosen rows of `parent`, like `parent.subset(rows)`, reusing this object's memory where it
  /// suffices: for loops that must not allocate. `parent` must not be this object.
  void assign_subset(const Correspondences& parent, std::span<const std::uint32_t> rows);

  /// Makes this the pairs (source of source_rows[k], target of target_rows[k]) of `parent`: mismatched correspondences,
  /// to see what chance gives. Otherwise as `assign_subset`. Throws std::invalid_argument if the sizes differ.
  void assign_pairs(const Correspondences& parent, std::span<const std::uint32_t> source_rows,
                    std::span<const std::uint32_t> target_rows);

  /// The same correspondences with source points, and their viewpoint, multiplied by `factor`, about the origin of
  /// their frame. Coordinates are rounded once more. Throws std::invalid_argument unless the factor is finite and > 0.
  [[nodiscard]] Correspondences with_scaled_source(double factor) const;

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] CorrespondenceView view() const noexcept { return {data_.get(), size_, padded_, scale_}; }
  operator CorrespondenceView() const noexcept { return view(); }  // NOLINT(google-explicit-constructor)

  [[nodiscard]] const std::array<double, 3>& source_centroid() const noexcept { return source_centroid_; }
  [[nodiscard]] const std::array<double, 3>& target_centroid() const noexcept { return target_centroid_; }
  [[nodiscard]] double scale() const noexcept { return scale_; }

  /// Where the source cloud was taken from, in the caller's source frame: its origin unless told otherwise. No kernel
  /// reads it, and no pose depends on it; whether a pose is believed may, since matches of a scan tend to keep the
  /// range about its sensor. Where nearly all rows keep ranges far better about another point, that is taken for it.
  [[nodiscard]] const std::array<double, 3>& source_viewpoint() const noexcept { return source_viewpoint_; }
  /// Throws std::invalid_argument at a coordinate that is not finite.
  void set_source_viewpoint(const std::array<double, 3>& viewpoint);

  /// Rows that are far from all others, ascending: NaN in the working frame. Most often none.
  [[nodiscard]] std::span<const std::uint32_t> far_rows() const noexcept { return far_rows_; }
  /// The other rows, ascending.
  [[nodiscard]] std::vector<std::uint32_t> near_rows() const;
  /// The least noise bound that residuals are not rounded beyond, caller's unit: 2^-20 of the working frame of the bulk
  /// (its size is at least one, at most two times that of the largest coordinate), or what the caller's type can tell
  /// so far from the origin.
  [[nodiscard]] double resolution() const noexcept { return resolution_; }

 private:
  struct AlignedDelete {
    void operator()(float* p) const noexcept;
  };

  template <typename T>
  void assign(PointSpan<T> source, PointSpan<T> target);
  void allocate(std::size_t size);
  void blank_far_rows();

  std::unique_ptr<float[], AlignedDelete> data_;
  std::size_t size_ = 0;
  std::size_t padded_ = 0;
  std::size_t capacity_ = 0;  // padded size that data_ has room for
  double scale_ = 1.0;
  double resolution_ = 0.0;
  std::array<double, 3> source_centroid_{};
  std::array<double, 3> target_centroid_{};
  std::array<double, 3> source_viewpoint_{};
  std::vector<std::uint32_t> far_rows_;
};

}  // namespace consimd
