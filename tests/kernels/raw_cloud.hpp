// Correspondences as raw arrays for the kernel tables, with any number in them, and the tables to test.
#pragma once

#include <consimd/kernels/isa.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <ostream>
#include <random>
#include <vector>

#include "dispatch.hpp"

namespace consimd {

inline void PrintTo(Isa isa, std::ostream* out) { *out << to_string(isa); }

namespace test {

/// `size` elements on their own 64-byte aligned piece of the heap: a sanitizer sees any access beyond.
template <typename T>
class ExactArray {
 public:
  explicit ExactArray(std::size_t size, T value = {})
      : data_(static_cast<T*>(::operator new (size * sizeof(T), std::align_val_t{64}))), size_(size) {
    std::uninitialized_fill_n(data_.get(), size, value);
  }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  const T& operator[](std::size_t i) const { return data_.get()[i]; }
  std::vector<T> values() const { return {data_.get(), data_.get() + size_}; }

 private:
  struct Delete {
    void operator()(T* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::unique_ptr<T, Delete> data_;
  std::size_t size_;
};

/// Uniform in [-1, 1), the same on every platform.
inline float uniform(std::mt19937& random) {
  return static_cast<float>(static_cast<std::int32_t>(random())) * 0x1p-31f;
}

enum class Kind { random, tied, huge, tiny, with_nan, with_infinity };
inline constexpr std::array kKinds{Kind::random, Kind::tied,     Kind::huge,
                                   Kind::tiny,   Kind::with_nan, Kind::with_infinity};

inline std::ostream& operator<<(std::ostream& out, Kind kind) {
  return out << std::array{
             "random", "tied", "huge", "tiny", "with NaN", "with infinity"}[static_cast<std::size_t>(kind)];
}

/// A length at which many tests of a cloud of this kind are close or equal to the threshold.
inline float bound_of(Kind kind) {
  switch (kind) {
    case Kind::tied:
      return 2.0f;
    case Kind::huge:
      return 1e9f;
    case Kind::tiny:
      return 1e-8f;
    default:
      return 0.25f;
  }
}

class RawCloud {
 public:
  RawCloud(std::size_t size, Kind kind, std::uint32_t seed)
      : size_(size), padded_((size + 63) / 64 * 64), random_(seed + static_cast<std::uint32_t>(size)) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    for (int row = 0; row < 6; ++row) rows_.emplace_back(padded_, kNan);
    for (std::size_t j = 0; j < size; ++j) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rows_[axis][j] = value(kind);
        // half of the correspondences nearly or exactly keep their place, so that tests pass as well as fail
        rows_[3 + axis][j] = j % 2 == 0 ? rows_[axis][j] * (kind == Kind::tied ? 1.0f : 1.0625f) : value(kind);
      }
    }
  }

  std::size_t size() const { return size_; }
  std::size_t words() const { return padded_ / 64; }
  std::size_t padded() const { return padded_; }
  std::uint32_t any_index() { return static_cast<std::uint32_t>(random_() % size_); }
  std::mt19937& random() { return random_; }

  detail::RawView view() const {
    return {{rows_[0].data(), rows_[1].data(), rows_[2].data()},
            {rows_[3].data(), rows_[4].data(), rows_[5].data()},
            size_,
            padded_};
  }

 private:
  float value(Kind kind) {
    const float unit = uniform(random_);
    const bool special = random_() % 8 == 0;
    switch (kind) {
      case Kind::random:
        return unit;
      case Kind::tied:
        return std::floor(4.0f * unit);
      case Kind::huge:
        return unit * (special ? 1e30f : 1e9f);
      case Kind::tiny:
        return unit * (special ? 1e-30f : 1e-8f);
      case Kind::with_nan:
        return special ? std::numeric_limits<float>::quiet_NaN() : unit;
      case Kind::with_infinity:
        return special ? std::copysign(std::numeric_limits<float>::infinity(), unit) : unit;
    }
    return unit;
  }

  std::size_t size_;
  std::size_t padded_;
  std::mt19937 random_;
  std::vector<ExactArray<float>> rows_;
};

/// The identity, under which tied clouds have residuals equal to their bound, or a small or large rotation with a small
/// translation.
inline WorkingPose any_pose(std::mt19937& random) {
  if (random() % 4 == 0) return {{1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f}, {}};
  const float angle = (random() % 4 == 0 ? 1.0f : 0.03f) * uniform(random);
  const float c = std::cos(angle);
  const float s = std::sin(angle);
  WorkingPose pose{{c, -s, 0.0f, s, c, 0.0f, 0.0f, 0.0f, 1.0f}, {}};
  for (float& t : pose.translation) t = 0.05f * uniform(random);
  return pose;
}

/// Runs `check(cloud, bound)` for every length up to four words and every kind of number.
template <typename Check>
void for_every_cloud(Check check) {
  for (const Kind kind : kKinds) {
    for (std::size_t size = 0; size <= 260; ++size) {
      SCOPED_TRACE(::testing::Message() << kind << " cloud of " << size);
      RawCloud cloud(size, kind, 17);
      check(cloud, bound_of(kind));
      if (::testing::Test::HasFatalFailure()) return;
    }
  }
}

/// A test that runs once for each instruction set that this processor supports.
class PerIsa : public ::testing::TestWithParam<Isa> {
 protected:
  const detail::KernelTable& table() const { return detail::table_of(GetParam()); }
};

#define CONSIMD_FOR_EACH_ISA(suite)                                                                        \
  INSTANTIATE_TEST_SUITE_P(, suite, ::testing::ValuesIn(supported_isas().begin(), supported_isas().end()), \
                           [](const auto& isa) { return std::string(to_string(isa.param)); })

/// Counts and bits that `passes(hypothesis, j)` asks for, against those that `counts_of` and `bits_of` give.
template <typename Passes, typename CountsOf, typename BitsOf>
void expect_consensus(const RawCloud& cloud, std::size_t hypotheses, Passes passes, CountsOf counts_of,
                      BitsOf bits_of) {
  std::vector<std::uint64_t> expected_bits(hypotheses * cloud.words(), 0);
  std::vector<std::uint32_t> expected_counts(hypotheses, 0);
  for (std::size_t h = 0; h < hypotheses; ++h) {
    for (std::size_t j = 0; j < cloud.size(); ++j) {
      if (!passes(h, j)) continue;
      expected_bits[h * cloud.words() + j / 64] |= std::uint64_t{1} << (j % 64);
      ++expected_counts[h];
    }
  }
  ExactArray<std::uint32_t> counts(hypotheses, 0xffffffff);
  counts_of(counts.data());
  ASSERT_EQ(counts.values(), expected_counts);

  ExactArray<std::uint32_t> counts_with_bits(hypotheses, 0xffffffff);
  ExactArray<std::uint64_t> bits(hypotheses * cloud.words(), ~std::uint64_t{0});
  bits_of(bits.data(), counts_with_bits.data());
  ASSERT_EQ(counts_with_bits.values(), expected_counts);
  ASSERT_EQ(bits.values(), expected_bits);
}

}  // namespace test
}  // namespace consimd
