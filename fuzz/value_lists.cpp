// What options of the command take as text: lists of numbers, shards, solvers with their options.
#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/registry.hpp>
#include <consimd/studies/shard.hpp>
#include <consimd/studies/value_list.hpp>

#include <cmath>

#include "holds.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace consimd;
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::may_refuse([&] {
    for (const double value : studies::parse_value_list(text)) fuzz::require(std::isfinite(value), "finite numbers");
  });
  fuzz::may_refuse([&] {
    const studies::Shard shard = studies::parse_shard(text);
    fuzz::require(shard.index >= 1 && shard.index <= shard.count, "a shard of its study");
    fuzz::require(studies::parse_shard(to_string(shard)) == shard, "shards that read back the same");
  });
  fuzz::may_refuse([&] { static_cast<void>(parse_isa(text)); });
  fuzz::may_refuse([&] {
    const std::string label = SolverChoice(text).label();
    fuzz::require(SolverChoice(label).label() == label, "labels that read back the same");
  });
  return 0;
}
