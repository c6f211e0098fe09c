#include <consimd/studies/kernel_timing.hpp>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include <consimd/kernels/isa.hpp>
#include <consimd/kernels/length_consistency.hpp>

namespace consimd::studies {
namespace {

/// The sum of the seeds: quick, and another one for another workload.
void sum(const KernelWorkload& workload, KernelOutput& output) {
  output.assign(2, 0);
  for (const std::uint32_t seed : workload.seeds) output[1] += seed;
}

TimedKernel sums() {
  return {.name = "sums",
          .item = "seeds",
          .items = [](const KernelWorkload& w) { return static_cast<double>(w.batch()); },
          .reference = sum,
          .variants = {{"again", sum}}};
}

constexpr double kShort = 1e-4;  // seconds

/// What() of the exception that timing ends with.
template <typename Exception>
std::string failure(const TimedKernel& kernel, const KernelTimingOptions& options) {
  try {
    (void)time_kernels({&kernel, 1}, options);
  } catch (const Exception& error) {
    return error.what();
  }
  return {};
}

TEST(KernelWorkload, IsTheSameForTheSameSizeAndBatch) {
  const KernelWorkload a(100), b(100), other(100, 8);
  EXPECT_EQ(a.size(), 100U);
  EXPECT_EQ(a.batch(), 64U);
  EXPECT_EQ(a.seeds, b.seeds);
  EXPECT_EQ(a.problem.target, b.problem.target);
  EXPECT_EQ(a.chosen, b.chosen);
  EXPECT_EQ(other.batch(), 8U);
  EXPECT_EQ(other.poses.size(), 8U);
  EXPECT_EQ(other.transforms.size(), 8U);
  EXPECT_EQ(other.triples.size(), 100U);
  EXPECT_TRUE(std::equal(other.seeds.begin(), other.seeds.end(), a.seeds.begin()));
  for (const std::uint32_t row : a.rows) EXPECT_TRUE(a.chosen[row / 64] >> (row % 64) & 1U);
  for (std::size_t j = 0; j < 128; ++j) EXPECT_TRUE(a.weights()[j] >= 0.0F && a.weights()[j] < 1.0F);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(a.weights()) % 64, 0U);
  EXPECT_EQ(std::ranges::count(a.problem.is_inlier, 1), 10);
}

TEST(KernelWorkload, NamesBadSizes) {
  EXPECT_THROW(KernelWorkload(2), std::invalid_argument);
  EXPECT_THROW(KernelWorkload(100, 0), std::invalid_argument);
}

TEST(TimeKernels, TimesReferenceAndVariantsOfEverySize) {
  const TimedKernel kernel = sums();
  const std::vector<KernelRate> rates =
      time_kernels({&kernel, 1}, {.sizes = {50, 100}, .batch = 16, .seconds = kShort, .repetitions = 3});
  ASSERT_EQ(rates.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(rates[k].size, k < 2 ? 50U : 100U);
    EXPECT_EQ(rates[k].variant, k % 2 == 0 ? "scalar" : "again");
    EXPECT_EQ(rates[k].item, "seeds");
    EXPECT_GT(rates[k].lowest, 0.0);
    EXPECT_LE(rates[k].lowest, rates[k].items_per_second);
    EXPECT_LE(rates[k].items_per_second, rates[k].highest);
  }
}

TEST(TimeKernels, HoldsTheKernelsOfTheLibraryAgainstTheReference) {
  const auto on = [](Isa isa) -> KernelCall {
    return [isa](const KernelWorkload& w, KernelOutput& counts) {
      set_active_isa(isa);
      counts.resize(w.batch());
      length_consistency_counts(w.correspondences, w.seeds, w.consistency_bound, counts);
    };
  };
  const Isa active = active_isa();
  TimedKernel kernel{.name = "length_consistency_counts",
                     .item = "pairs",
                     .items = [](const KernelWorkload& w) { return static_cast<double>(w.batch() * w.size()); },
                     .reference = on(Isa::scalar),
                     .variants = {}};
  for (const Isa isa : supported_isas()) {
    if (isa != Isa::scalar) kernel.variants.push_back({std::string(to_string(isa)), on(isa)});
  }
  EXPECT_EQ(time_kernels({&kernel, 1}, {.sizes = {333}, .seconds = kShort, .repetitions = 1}).size(),
            kernel.variants.size() + 1);
  set_active_isa(active);
}

TEST(TimeKernels, NamesAVariantThatDiffers) {
  TimedKernel kernel = sums();
  kernel.variants.push_back({"wrong", [](const KernelWorkload& w, KernelOutput& output) {
                               sum(w, output);
                               if (w.size() == 100) output[0] = 7;
                             }});
  const KernelTimingOptions options{.sizes = {50, 100}, .seconds = kShort, .repetitions = 1};
  EXPECT_EQ(failure<std::runtime_error>(kernel, options),
            "sums, wrong of 100 correspondences: differs from the reference: word 0 is 7, not 0");
  kernel.variants.back().call = [](const KernelWorkload&, KernelOutput& output) { output.clear(); };
  EXPECT_EQ(failure<std::runtime_error>(kernel, options),
            "sums, wrong of 50 correspondences: differs from the reference: 0 words, not 2");
  kernel.agrees = [](const KernelOutput&, const KernelOutput& reference) { return reference.size() == 2; };
  EXPECT_EQ(failure<std::runtime_error>(kernel, options), "");
}

TEST(TimeKernels, NamesBadArguments) {
  const KernelTimingOptions options{.sizes = {50}, .seconds = kShort, .repetitions = 1};
  TimedKernel kernel = sums();
  kernel.variants.push_back({"again", sum});
  EXPECT_EQ(failure<std::invalid_argument>(kernel, options), "kernel sums: variant again is there twice");
  kernel.variants.back() = {"scalar", sum};
  EXPECT_EQ(failure<std::invalid_argument>(kernel, options), "kernel sums: variant scalar is there twice");
  kernel.variants.back() = {"none", {}};
  EXPECT_EQ(failure<std::invalid_argument>(kernel, options), "kernel sums: variant none is empty");
  kernel = sums();
  kernel.reference = {};
  EXPECT_NE(failure<std::invalid_argument>(kernel, options), "");
  KernelTimingOptions wrong = options;
  wrong.seconds = 0.0;
  EXPECT_EQ(failure<std::invalid_argument>(sums(), wrong), "seconds: expected a time above 0, got 0");
  wrong = options;
  wrong.repetitions = 0;
  EXPECT_NE(failure<std::invalid_argument>(sums(), wrong), "");
  const std::vector<TimedKernel> twice{sums(), sums()};
  EXPECT_THROW((void)time_kernels(twice, options), std::invalid_argument);
}

TEST(KernelRateTable, HasAColumnForEveryVariant) {
  const std::vector<KernelRate> rates{
      {.kernel = "a", .item = "pairs", .size = 10, .variant = "scalar", .items_per_second = 1e9},
      {.kernel = "a", .item = "pairs", .size = 10, .variant = "avx2", .items_per_second = 2.5e9},
      {.kernel = "a", .item = "pairs", .size = 20, .variant = "scalar", .items_per_second = 7e9},
      {.kernel = "b", .item = "bits", .size = 10, .variant = "scalar", .items_per_second = 1.234e11},
      {.kernel = "b", .item = "bits", .size = 10, .variant = "mine", .items_per_second = 3.7e12},
  };
  const TextTable table = kernel_rate_table(rates, 10);
  const std::vector<std::string> columns{"kernel",        "of",          "scalar",     "avx2", "mine",
                                         "last / scalar", "last / avx2", "last / mine"};
  EXPECT_EQ(table.columns, columns);
  ASSERT_EQ(table.rows.size(), 2U);
  const std::vector<std::string> a{"a", "pairs", "1", "2.5", "-", "2.5", "1", "-"};
  const std::vector<std::string> b{"b", "bits", "123", "-", "3700", "30", "-", "1"};
  EXPECT_EQ(table.rows[0], a);
  EXPECT_EQ(table.rows[1], b);
  EXPECT_TRUE(kernel_rate_table(rates, 30).rows.empty());
}

}  // namespace
}  // namespace consimd::studies
