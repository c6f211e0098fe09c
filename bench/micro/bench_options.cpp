#include "bench_options.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "text/words.hpp"

namespace consimd::bench {
namespace {

constexpr std::size_t kLargest = 10'000'000;

std::vector<std::size_t> numbers_of(std::string_view option, std::string_view list, std::size_t least) {
  std::vector<std::size_t> numbers;
  for (const std::string_view part : text::split(list, ',')) {
    const auto number = text::number_in<std::size_t>(part);
    if (!number || *number < least || *number > kLargest) {
      throw std::invalid_argument(fmt::format("{}: expected whole numbers from {} to {}, separated by commas, got '{}'",
                                              option, least, kLargest, part));
    }
    if (std::ranges::find(numbers, *number) == numbers.end()) numbers.push_back(*number);
  }
  return numbers;
}

std::vector<Isa> isas_of(std::string_view list) {
  const auto supported = supported_isas();
  std::vector<std::string_view> names;
  for (const Isa isa : supported) names.push_back(to_string(isa));
  std::vector<Isa> isas;
  for (const std::string_view part : text::split(list, ',')) {
    const auto found = std::ranges::find(names, part);
    if (found == names.end()) {
      throw std::invalid_argument(
          fmt::format("--isas: expected some of {}, which this machine has, got '{}'", fmt::join(names, ", "), part));
    }
    const Isa isa = supported[static_cast<std::size_t>(found - names.begin())];
    if (std::ranges::find(isas, isa) == isas.end()) isas.push_back(isa);
  }
  return isas;
}

/// The value of the option at `k`, which is taken out with it; nothing if another argument is there.
std::optional<std::string> take_value(std::vector<char*>& arguments, std::size_t k, std::string_view option) {
  const std::string_view argument = arguments[k];
  if (!argument.starts_with(option)) return std::nullopt;
  const auto at = arguments.begin() + static_cast<std::ptrdiff_t>(k);
  if (argument.size() > option.size()) {
    if (argument[option.size()] != '=') return std::nullopt;
    std::string value(argument.substr(option.size() + 1));
    arguments.erase(at);
    return value;
  }
  if (k + 1 == arguments.size()) throw std::invalid_argument(fmt::format("{}: expected a value", option));
  std::string value = arguments[k + 1];
  arguments.erase(at, at + 2);
  return value;
}

}  // namespace

BenchOptions take_options(std::vector<char*>& arguments) {
  BenchOptions options;
  const auto supported = supported_isas();
  options.isas.assign(supported.begin(), supported.end());
  for (std::size_t k = 1; k < arguments.size();) {
    if (const auto sizes = take_value(arguments, k, "--sizes")) {
      options.sizes = numbers_of("--sizes", *sizes, 3);
    } else if (const auto batches = take_value(arguments, k, "--batch")) {
      options.batches = numbers_of("--batch", *batches, 1);
    } else if (const auto isas = take_value(arguments, k, "--isas")) {
      options.isas = isas_of(*isas);
    } else {
      ++k;
    }
  }
  return options;
}

void print_help() {
  const BenchOptions defaults;
  std::fputs(
      fmt::format(
          "Benchmarks of consimd's kernels, of the front end's, of graph stages, refinement and registrations. Of "
          "the first ones:\n"
          "  --sizes N[,N...]    correspondences, of matrices up to 10000 (default: {})\n"
          "  --batch N[,N...]    hypotheses that a kernel is given at once (default: {})\n"
          "  --isas NAME[,...]   instruction sets (default: all that the machine has)\n"
          "The rest are Google Benchmark's:\n",
          fmt::join(defaults.sizes, ","), fmt::join(defaults.batches, ","))
          .c_str(),
      stdout);
  benchmark::PrintDefaultHelp();
}

}  // namespace consimd::bench
