// Random numbers as a pure function of (seed, cell, trial, purpose): the same on every machine, for any order of
// trials.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>

#include <Random123/philox.h>
#include <Eigen/Geometry>

#include <consimd/kernels/elementary_functions.hpp>

namespace consimd::synth {

/// The rotation by `angle`, in radians, about a unit vector.
inline Eigen::Quaterniond turn_about(const Eigen::Vector3d& axis, double angle) noexcept {
  const auto [sine, cosine] = elementary::sine_cosine(0.5 * angle);
  return {cosine, sine * axis.x(), sine * axis.y(), sine * axis.z()};
}

/// Names one problem among all: its random numbers depend on nothing else.
struct ProblemKey {
  std::uint64_t seed;
  std::uint64_t cell;  ///< hash of the options that make a cell of a study
  std::uint64_t trial;
};

/// What a sequence of random numbers is used for. Separate sequences keep one use from shifting another's numbers.
enum class Purpose : std::uint64_t { motion, points, noise, outliers, order };

/// A sequence of random numbers: Philox4x64-10 in counter mode with key (seed, cell) and counter (i, trial, purpose,
/// 0).
class RandomStream {
 public:
  RandomStream(const ProblemKey& key, Purpose purpose) noexcept
      : key_{{key.seed, key.cell}}, counter_{{0, key.trial, static_cast<std::uint64_t>(purpose), 0}} {}

  /// 64 uniform bits.
  std::uint64_t bits() noexcept {
    if (used_ == kWords) {
      words_ = r123::Philox4x64{}(counter_, key_);
      ++counter_[0];
      used_ = 0;
    }
    return words_[used_++];
  }

  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  /// Uniform in [low, high].
  double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }

  /// Uniform in {0, ..., bound - 1}, bound >= 1, by Lemire's multiply-and-reject: no bias.
  std::uint32_t below(std::uint32_t bound) noexcept {
    const std::uint32_t rejected = -bound % bound;  // 2^32 mod bound
    std::uint64_t product = 0;
    do {
      product = (bits() >> 32) * bound;
    } while (static_cast<std::uint32_t>(product) < rejected);
    return static_cast<std::uint32_t>(product >> 32);
  }

  /// Standard normal, by Box and Muller; the second of a pair is kept for the next call.
  double gaussian() noexcept {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * elementary::log(1.0 - uniform()));
    const auto angle = elementary::sine_cosine(2.0 * std::numbers::pi * uniform());
    spare_ = radius * angle.sine;
    has_spare_ = true;
    return radius * angle.cosine;
  }

  Eigen::Vector3d gaussian_vector() noexcept {
    const double x = gaussian(), y = gaussian(), z = gaussian();
    return {x, y, z};
  }

  /// Uniform in the box [-half_extents, half_extents].
  Eigen::Vector3d in_box(const Eigen::Vector3d& half_extents) noexcept {
    const double x = uniform(-1.0, 1.0), y = uniform(-1.0, 1.0), z = uniform(-1.0, 1.0);
    return {half_extents.x() * x, half_extents.y() * y, half_extents.z() * z};
  }

  /// Uniform over all rotations: K. Shoemake, "Uniform random rotations", Graphics Gems III, 1992.
  Eigen::Matrix3d rotation() noexcept {
    const double u = uniform();
    const auto a = elementary::sine_cosine(2.0 * std::numbers::pi * uniform());
    const auto b = elementary::sine_cosine(2.0 * std::numbers::pi * uniform());
    const double s = std::sqrt(1.0 - u), t = std::sqrt(u);
    return Eigen::Quaterniond(t * b.cosine, s * a.sine, s * a.cosine, t * b.sine).toRotationMatrix();
  }

  /// Fisher-Yates: every order equally likely. At most 2^32 - 1 values.
  template <typename T>
  void shuffle(std::span<T> values) noexcept {
    for (auto left = static_cast<std::uint32_t>(values.size()); left > 1; --left) {
      std::swap(values[left - 1], values[below(left)]);
    }
  }

 private:
  static constexpr std::size_t kWords = 4;

  r123::Philox4x64::key_type key_;
  r123::Philox4x64::ctr_type counter_;
  r123::Philox4x64::ctr_type words_{};
  std::size_t used_ = kWords;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace consimd::synth
