// Best matches of descriptors on every instruction set, in any number of parts, against the scalar reference: equal
// lists.
#include <consimd/kernels/descriptor_matches.hpp>
#include <consimd/kernels/isa.hpp>

#include <fuzzer/FuzzedDataProvider.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "holds.hpp"

namespace {

using namespace consimd;

/// Rows about few centres, of few distinct values, so that many are copies and distances tie.
std::vector<float> make_descriptors(FuzzedDataProvider& input, std::size_t length) {
  const auto size = input.ConsumeIntegralInRange<std::size_t>(0, 300);
  const auto centres = input.ConsumeIntegralInRange<std::size_t>(1, 8);
  const auto spread = input.ConsumeIntegralInRange<int>(0, 3);
  const float unit = std::ldexp(1.0f, input.ConsumeIntegralInRange<int>(-30, 30));
  std::vector<float> values;
  for (std::size_t i = 0; i < size; ++i) {
    const auto centre = static_cast<float>(10 * (i % centres));
    for (std::size_t c = 0; c < length; ++c) {
      values.push_back(unit * (centre + static_cast<float>(input.ConsumeIntegralInRange<int>(-spread, spread))));
    }
  }
  return values;
}

std::vector<std::pair<std::uint32_t, std::int32_t>> list_of(const BestMatches& matches) {
  std::vector<std::pair<std::uint32_t, std::int32_t>> list;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    for (std::size_t rank = 0; rank < matches.k(); ++rank) {
      list.emplace_back(matches.index(i, rank), matches.squared_distance(i, rank));
    }
  }
  return list;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzedDataProvider input(data, size);
  const auto length = input.ConsumeIntegralInRange<std::size_t>(1, 40);
  const auto k = input.ConsumeIntegralInRange<std::size_t>(1, 8);
  const auto parts = input.ConsumeIntegralInRange<std::size_t>(1, 5);
  const std::vector<float> source = make_descriptors(input, length);
  const std::vector<float> target = make_descriptors(input, length);
  const FixedPointForm form(source, target, length);
  const FixedPointDescriptors queries(source, form), targets(target, form);
  // In `parts` parts, each with lists of the targets of its own.
  const auto matches = [&](Isa isa, std::size_t in_parts) {
    set_active_isa(isa);
    BestMatches of_queries(queries, k), of_targets(targets, k);
    for (std::size_t part = 0; part < in_parts; ++part) {
      BestMatches of_part(targets, k);
      best_matches(queries, targets, of_queries, of_part, part, in_parts);
      of_targets.merge(of_part);
    }
    return std::pair(list_of(of_queries), list_of(of_targets));
  };
  const auto expected = matches(Isa::scalar, 1);
  for (const Isa isa : supported_isas()) {
    fuzz::require(matches(isa, parts) == expected, "equal lists on every instruction set");
  }
  return 0;
}
