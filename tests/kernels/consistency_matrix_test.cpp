#include <consimd/kernels/consistency_matrix.hpp>

#include <algorithm>
#include <bit>

#include <consimd/kernels/length_consistency.hpp>

#include "raw_cloud.hpp"

namespace consimd::test {
namespace {

class Matrix : public PerIsa {};
CONSIMD_FOR_EACH_ISA(Matrix);

void expect_rows_of_length_bits(const RawCloud& cloud, const detail::KernelTable& table, float bound) {
  ExactArray<std::uint64_t> bits(cloud.size() * cloud.words(), ~std::uint64_t{0});
  ExactArray<std::uint32_t> degrees(cloud.size(), 0xffffffff);
  table.consistency_matrix(cloud.view(), bound, bits.data(), degrees.data());

  std::vector<std::uint32_t> seeds(cloud.size());
  for (std::uint32_t i = 0; i < cloud.size(); ++i) seeds[i] = i;
  ExactArray<std::uint64_t> rows(cloud.size() * cloud.words());
  ExactArray<std::uint32_t> counts(cloud.size());
  detail::table_of(Isa::scalar)
      .length_bits(cloud.view(), seeds.data(), seeds.size(), bound, rows.data(), counts.data());
  ASSERT_EQ(bits.values(), rows.values());
  ASSERT_EQ(degrees.values(), counts.values());
}

TEST_P(Matrix, HasTheRowsOfLengthConsistency) {
  for_every_cloud([&](RawCloud& cloud, float bound) { expect_rows_of_length_bits(cloud, table(), bound); });
}

TEST_P(Matrix, CrossesRunsOfTiles) { expect_rows_of_length_bits(RawCloud(1300, Kind::random, 1), table(), 0.1f); }

TEST_P(Matrix, IsSymmetricWithItsDiagonalSet) {
  set_active_isa(GetParam());
  RawCloud cloud(333, Kind::random, 2);
  std::vector<float> p, q;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p.insert(p.end(), cloud.view().source[axis], cloud.view().source[axis] + cloud.size());
    q.insert(q.end(), cloud.view().target[axis], cloud.view().target[axis] + cloud.size());
  }
  const Correspondences c(PointSpan<float>::planar(p.data(), cloud.size()),
                          PointSpan<float>::planar(q.data(), cloud.size()));
  ConsistencyMatrix matrix;
  matrix.compute(c, 0.1);
  ASSERT_EQ(matrix.size(), 333u);
  ASSERT_EQ(matrix.words(), 6u);
  const auto bit = [&](std::size_t i, std::size_t j) { return (matrix.row(i)[j / 64] >> (j % 64) & 1) != 0; };
  for (std::size_t i = 0; i < 333; ++i) {
    EXPECT_TRUE(bit(i, i));
    EXPECT_EQ(matrix.row(i)[5] >> (333 - 5 * 64), 0u);
    EXPECT_EQ(popcount(matrix.row(i)), matrix.degrees()[i]);
    for (std::size_t j = 0; j < i; ++j) ASSERT_EQ(bit(i, j), bit(j, i));
  }

  ConsistencyMatrix copy = matrix;
  EXPECT_EQ(and_popcount(copy.row(7), matrix.row(7)), matrix.degrees()[7]);
  matrix.compute(c.subset(std::vector<std::uint32_t>{1, 2}), 0.1);
  EXPECT_EQ(matrix.size(), 2u);
  matrix.compute(Correspondences(), 0.1);
  EXPECT_EQ(matrix.size(), 0u);
  EXPECT_EQ(ConsistencyMatrix::memory_bytes(3000), 3000u * 47 * 8);
}

void expect_separated(const RawCloud& cloud, const detail::KernelTable& table, detail::SeparatedBounds bounds) {
  ExactArray<std::uint64_t> bits(cloud.size() * cloud.words(), ~std::uint64_t{0});
  ExactArray<std::uint32_t> degrees(cloud.size(), 0xffffffff);
  table.separated_matrix(cloud.view(), bounds, bits.data(), degrees.data());
  ExactArray<std::uint64_t> expected_bits(cloud.size() * cloud.words());
  ExactArray<std::uint32_t> expected_degrees(cloud.size());
  detail::table_of(Isa::scalar).separated_matrix(cloud.view(), bounds, expected_bits.data(), expected_degrees.data());
  ASSERT_EQ(bits.values(), expected_bits.values());
  ASSERT_EQ(degrees.values(), expected_degrees.values());
}

TEST_P(Matrix, LeavesShortPairsOut) {
  // The tiling is that of the matrix with short pairs: a few lengths on both sides of a word tell.
  for (const Kind kind : kKinds) {
    const float bound = bound_of(kind);
    for (const std::size_t size : {0U, 1U, 2U, 17U, 63U, 64U, 65U, 130U, 192U, 260U}) {
      SCOPED_TRACE(::testing::Message() << kind << " cloud of " << size);
      expect_separated(RawCloud(size, kind, 17), table(), {bound, 4.0f * bound});
    }
  }
  expect_separated(RawCloud(1300, Kind::random, 1), table(), {0.1f, 1.5f});
}

TEST_P(Matrix, SeparationIsTheSumOfBothLengths) {
  constexpr float kBound = 0.1f;
  constexpr double kSeparation = 1.5;
  const RawCloud cloud(300, Kind::random, 3);
  const detail::RawView view = cloud.view();
  ExactArray<std::uint64_t> bits(cloud.size() * cloud.words());
  ExactArray<std::uint32_t> degrees(cloud.size());
  table().consistency_matrix(view, kBound, bits.data(), degrees.data());
  ExactArray<std::uint64_t> separated(cloud.size() * cloud.words());
  table().separated_matrix(view, {kBound, static_cast<float>(kSeparation)}, separated.data(), degrees.data());
  const auto length = [](const float* const points[3], std::size_t i, std::size_t j) {
    return std::hypot(static_cast<double>(points[0][i] - points[0][j]),
                      static_cast<double>(points[1][i] - points[1][j]),
                      static_cast<double>(points[2][i] - points[2][j]));
  };
  std::size_t kept = 0;
  std::size_t left_out = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (std::size_t j = 0; j < cloud.size(); ++j) {
      const auto bit = [&](const ExactArray<std::uint64_t>& matrix) {
        return (matrix[i * cloud.words() + j / 64] >> (j % 64) & 1) != 0;
      };
      const double sum = length(view.source, i, j) + length(view.target, i, j);
      if (std::abs(sum - kSeparation) < 1e-5) continue;
      ASSERT_EQ(bit(separated), bit(bits) && sum > kSeparation) << i << ", " << j;
      if (bit(bits)) ++(bit(separated) ? kept : left_out);
    }
  }
  EXPECT_GT(kept, 1000u);
  EXPECT_GT(left_out, 1000u);
}

TEST_P(Matrix, SumsWhatItsRowsMask) {
  std::mt19937 random(6);
  for (std::size_t words = 0; words <= 40; words += words < 6 ? 1 : 17) {
    constexpr std::size_t kRows = 11;
    ExactArray<std::uint64_t> rows(kRows * words);
    for (std::size_t k = 0; k < kRows * words; ++k) {
      rows[k] = random() % 5 == 0 ? 0 : std::uint64_t{random()} << 32 | random();
    }
    ExactArray<float> values(64 * words);
    for (std::size_t k = 0; k < 64 * words; ++k) {
      values[k] = random() % 50 == 0 ? -0.0f : random() % 300 == 0 ? 1e30f : uniform(random);
    }
    for (std::size_t n = 0; n <= kRows; ++n) {
      ExactArray<float> sums(n, -1.0f);
      table().masked_row_sums(rows.data(), words, n, values.data(), sums.data());
      ExactArray<float> expected(n);
      detail::table_of(Isa::scalar).masked_row_sums(rows.data(), words, n, values.data(), expected.data());
      ASSERT_EQ(sums.values(), expected.values());
      for (std::size_t r = 0; r < n; ++r) ASSERT_EQ(std::signbit(sums[r]), std::signbit(expected[r]));
    }
  }
}

TEST_P(Matrix, SumsIgnoreWhatIsNotMasked) {
  const std::array<std::uint64_t, 1> row{5};
  std::array<float, 64> values{};
  values.fill(std::numeric_limits<float>::quiet_NaN());
  values[0] = 2.0f;
  values[2] = 40.0f;
  float sum = 0.0f;
  table().masked_row_sums(row.data(), 1, 1, values.data(), &sum);
  EXPECT_EQ(sum, 42.0f);
}

TEST_P(Matrix, CountsCommonBits) {
  std::mt19937 random(4);
  for (std::size_t words = 0; words <= 600; words += words < 40 ? 1 : 37) {
    ExactArray<std::uint64_t> set(words);
    ExactArray<std::uint64_t> rows(5 * words);
    const auto any_word = [&] {
      return (std::uint64_t{random()} << 32 | random()) & (random() % 5 == 0 ? 0 : ~std::uint64_t{0});
    };
    for (std::size_t k = 0; k < words; ++k) set[k] = any_word();
    for (std::size_t k = 0; k < 5 * words; ++k) rows[k] = random() % 7 == 0 ? ~std::uint64_t{0} : any_word();
    const std::array<std::uint32_t, 4> chosen{4, 0, 2, 2};
    ExactArray<std::uint32_t> counts(4);
    table().and_popcount_rows(rows.data(), words, set.data(), chosen.data(), 4, counts.data());
    for (std::size_t r = 0; r < 4; ++r) {
      std::uint32_t expected = 0;
      for (std::size_t k = 0; k < words; ++k) {
        expected += static_cast<std::uint32_t>(std::popcount(set[k] & rows[chosen[r] * words + k]));
      }
      EXPECT_EQ(counts[r], expected);
      EXPECT_EQ(table().and_popcount(set.data(), rows.data() + chosen[r] * words, words), expected);
    }
  }
}

#ifdef __x86_64__
TEST(VectorPopcount, EqualsThePortableForm) {
  // Where the processor counts bits in vectors the table of AVX-512 does; the form for other processors must agree.
  const auto supported = supported_isas();
  if (std::find(supported.begin(), supported.end(), Isa::avx512) == supported.end()) GTEST_SKIP() << "no AVX-512 here";
  std::mt19937 random(5);
  for (std::size_t words = 0; words <= 600; words += words < 40 ? 1 : 37) {
    ExactArray<std::uint64_t> a(words);
    ExactArray<std::uint64_t> b(words);
    for (std::size_t k = 0; k < words; ++k) a[k] = std::uint64_t{random()} << 32 | random();
    for (std::size_t k = 0; k < words; ++k) b[k] = std::uint64_t{random()} << 32 | random();
    EXPECT_EQ(detail::avx512::table().and_popcount(a.data(), b.data(), words),
              detail::table_of(Isa::avx512).and_popcount(a.data(), b.data(), words));
  }
}
#endif

TEST(MatrixArguments, AreChecked) {
  const std::array<double, 6> points{0, 0, 0, 1, 0, 0};
  const auto span = PointSpan<double>::interleaved(points.data(), 2);
  ConsistencyMatrix matrix;
  EXPECT_THROW(matrix.compute(Correspondences(span, span), 0.0), std::invalid_argument);
  matrix.compute(Correspondences(span, span), 0.1);
  std::vector<std::uint32_t> rows{0, 2};
  std::vector<std::uint32_t> counts(2);
  EXPECT_THROW(and_popcount_rows(matrix, matrix.row(0), rows, counts), std::out_of_range);
  rows[1] = 1;
  EXPECT_THROW(and_popcount_rows(matrix, {}, rows, counts), std::invalid_argument);
  EXPECT_THROW(and_popcount_rows(matrix, matrix.row(0), rows, std::span(counts).first(1)), std::invalid_argument);
  and_popcount_rows(matrix, matrix.row(0), rows, counts);
  EXPECT_EQ(counts, (std::vector<std::uint32_t>{2, 2}));
  const std::vector<std::uint64_t> bits{1, 3, 4, 6};
  and_popcount_rows(bits, std::span(bits).first(2), rows, counts);
  EXPECT_EQ(counts, (std::vector<std::uint32_t>{3, 1}));
  EXPECT_THROW(and_popcount_rows(bits, std::span(bits).first(3), rows, counts), std::invalid_argument);
  EXPECT_THROW(and_popcount_rows(bits, bits, rows, counts), std::out_of_range);
  EXPECT_THROW((void)and_popcount(matrix.row(0), {}), std::invalid_argument);

  const std::vector<float> values(kBlock, 1.0f);
  std::vector<float> sums(2);
  masked_row_sums(matrix, 0, values, sums);
  EXPECT_EQ(sums, (std::vector<float>{2.0f, 2.0f}));
  masked_row_sums(matrix, 2, values, {});
  EXPECT_THROW(masked_row_sums(matrix, 0, std::span(values).first(2), sums), std::invalid_argument);
  EXPECT_THROW(masked_row_sums(matrix, 1, values, sums), std::invalid_argument);
  EXPECT_THROW(masked_row_sums(matrix, 3, values, {}), std::invalid_argument);

  const Correspondences pair(span, span);
  for (const double separation : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(matrix.compute_separated(pair, 0.1, separation), std::invalid_argument);
  }
  EXPECT_THROW(matrix.compute_separated(pair, 0.0, 1.0), std::invalid_argument);
  matrix.compute_separated(pair, 0.1, 1.9);
  EXPECT_EQ(matrix.row(0)[0], 2u);
  EXPECT_EQ(matrix.row(1)[0], 1u);
  matrix.compute_separated(pair, 0.1, 2.1);
  EXPECT_EQ(matrix.degrees()[0] + matrix.degrees()[1], 0u);
}

}  // namespace
}  // namespace consimd::test
