#include <consimd/studies/kernel_timing.hpp>

#include <algorithm>
#include <ctime>
#include <map>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include <consimd/studies/statistics.hpp>

namespace consimd::studies {
namespace {

constexpr std::string_view kReference = "scalar";

void check(std::span<const TimedKernel> kernels, const KernelTimingOptions& options) {
  if (!(options.seconds > 0.0)) {
    throw std::invalid_argument(fmt::format("seconds: expected a time above 0, got {}", options.seconds));
  }
  if (options.repetitions < 1) throw std::invalid_argument("repetitions: expected 1 or more, got 0");
  std::set<std::string> names;
  for (const TimedKernel& kernel : kernels) {
    if (!names.insert(kernel.name).second) {
      throw std::invalid_argument(fmt::format("kernel {} is there twice", kernel.name));
    }
    if (!kernel.reference || !kernel.items) {
      throw std::invalid_argument(fmt::format("kernel {}: its reference or its number of items is empty", kernel.name));
    }
    std::set<std::string> variants{std::string(kReference)};
    for (const KernelVariant& variant : kernel.variants) {
      if (!variant.call) {
        throw std::invalid_argument(fmt::format("kernel {}: variant {} is empty", kernel.name, variant.name));
      }
      if (!variants.insert(variant.name).second) {
        throw std::invalid_argument(fmt::format("kernel {}: variant {} is there twice", kernel.name, variant.name));
      }
    }
  }
}

bool agree(const TimedKernel& kernel, const KernelOutput& output, const KernelOutput& reference) {
  return kernel.agrees ? kernel.agrees(output, reference) : output == reference;
}

[[noreturn]] void tell_disagreement(const TimedKernel& kernel, std::string_view variant, std::size_t size,
                                    const KernelOutput& output, const KernelOutput& reference) {
  const auto [found, wanted] = std::ranges::mismatch(output, reference);
  const std::string where = found == output.end() || wanted == reference.end()
                                ? fmt::format("{} words, not {}", output.size(), reference.size())
                                : fmt::format("word {} is {}, not {}", found - output.begin(), *found, *wanted);
  throw std::runtime_error(
      fmt::format("{}, {} of {} correspondences: differs from the reference: {}", kernel.name, variant, size, where));
}

/// Calls a second, over at least `seconds`.
double call_rate(const KernelCall& call, const KernelWorkload& workload, KernelOutput& output, double seconds) {
  for (std::uint64_t calls = 1;; calls *= 2) {
    const std::clock_t start = std::clock();
    for (std::uint64_t k = 0; k < calls; ++k) call(workload, output);
    const double taken = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (taken >= seconds) return static_cast<double>(calls) / taken;
  }
}

/// A variant on a workload, and its rates so far.
struct Measurement {
  const TimedKernel* kernel;
  std::string_view variant;
  const KernelCall* call;
  KernelOutput output;
  std::vector<double> rates;
};

std::vector<Measurement> checked_measurements(std::span<const TimedKernel> kernels, const KernelWorkload& workload) {
  std::vector<Measurement> measurements;
  for (const TimedKernel& kernel : kernels) {
    KernelOutput reference;
    kernel.reference(workload, reference);
    measurements.push_back({&kernel, kReference, &kernel.reference, reference, {}});
    for (const KernelVariant& variant : kernel.variants) {
      KernelOutput output;
      variant.call(workload, output);
      if (!agree(kernel, output, reference)) {
        tell_disagreement(kernel, variant.name, workload.size(), output, reference);
      }
      measurements.push_back({&kernel, variant.name, &variant.call, std::move(output), {}});
    }
  }
  return measurements;
}

/// Three digits, without an exponent.
std::string digits(double value) {
  return value >= 99.95 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

}  // namespace

std::vector<KernelRate> time_kernels(std::span<const TimedKernel> kernels, const KernelTimingOptions& options) {
  check(kernels, options);
  std::vector<KernelRate> rates;
  for (const std::size_t size : options.sizes) {
    const KernelWorkload workload(size, options.batch);
    std::vector<Measurement> measurements = checked_measurements(kernels, workload);
    for (std::size_t repetition = 0; repetition < options.repetitions; ++repetition) {
      for (Measurement& one : measurements) {
        const double calls = call_rate(*one.call, workload, one.output, options.seconds);
        one.rates.push_back(calls * one.kernel->items(workload));
      }
    }
    for (const Measurement& one : measurements) {
      const auto [lowest, highest] = std::ranges::minmax(one.rates);
      rates.push_back({.kernel = one.kernel->name,
                       .item = one.kernel->item,
                       .size = size,
                       .variant = std::string(one.variant),
                       .items_per_second = median(one.rates),
                       .lowest = lowest,
                       .highest = highest});
    }
  }
  return rates;
}

TextTable kernel_rate_table(std::span<const KernelRate> rates, std::size_t size) {
  std::vector<std::string> kernels, variants;
  std::map<std::pair<std::string, std::string>, double> by_name;
  std::map<std::string, std::string> items, last;
  for (const KernelRate& rate : rates) {
    if (rate.size != size) continue;
    if (std::ranges::find(kernels, rate.kernel) == kernels.end()) kernels.push_back(rate.kernel);
    if (std::ranges::find(variants, rate.variant) == variants.end()) variants.push_back(rate.variant);
    by_name[{rate.kernel, rate.variant}] = rate.items_per_second / 1e9;
    items[rate.kernel] = rate.item;
    last[rate.kernel] = rate.variant;
  }
  TextTable table{.name = fmt::format("kernels_{}", size),
                  .title = fmt::format("{} correspondences, in 10^9 a second", size),
                  .caption = {},
                  .columns = {"kernel", "of"},
                  .rows = {}};
  table.columns.insert(table.columns.end(), variants.begin(), variants.end());
  for (const std::string& variant : variants) table.columns.push_back("last / " + variant);
  for (const std::string& kernel : kernels) {
    std::vector<std::string> row{kernel, items[kernel]};
    const auto cell = [&](const std::string& variant, const auto& text) {
      const auto found = by_name.find({kernel, variant});
      row.push_back(found == by_name.end() ? "-" : text(found->second));
    };
    for (const std::string& variant : variants) cell(variant, digits);
    const double best = by_name[{kernel, last[kernel]}];
    for (const std::string& variant : variants) cell(variant, [best](double rate) { return digits(best / rate); });
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace consimd::studies
