// A number that stands for the bits of results.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <consimd/poses/rigid_fit.hpp>

namespace consimd::golden {

/// FNV-1a over words of 64 bits.
class Digest {
 public:
  void add(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001b3; }
  /// All NaN are one: their bits are no result.
  void add(double value) { add(value == value ? std::bit_cast<std::uint64_t>(value) : ~std::uint64_t{0}); }
  void add(std::string_view text) {
    for (const char c : text) add(std::uint64_t{static_cast<unsigned char>(c)});
  }
  template <typename Range>
  void add_all(const Range& values) {
    add(std::uint64_t{values.size()});
    for (const auto& value : values) add(value);
  }
  void add(const RigidTransform& pose) { add_matrix(pose.matrix()); }
  template <typename Matrix>
  void add_matrix(const Matrix& m) {
    for (Eigen::Index i = 0; i < m.size(); ++i) add(double{m.data()[i]});
  }

  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

/// Names "KIND:WHAT" and digests.
using Digests = std::vector<std::pair<std::string, std::uint64_t>>;

/// Of registrations by every solver.
void add_registrations(Digests& digests);

/// Of the matches and the pose of a pair of clouds.
void add_clouds(Digests& digests);

/// Of a small noise study: its records without their times.
void add_study(Digests& digests);

}  // namespace consimd::golden
