// summary.json.
#include <consimd/studies/study_summary.hpp>

#include "holds.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace consimd;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::may_refuse([&] { static_cast<void>(studies::shard_of(text)); });
  fuzz::may_refuse([&] {
    const studies::SweepOptions options = studies::options_of(text);
    static_cast<void>(studies::difference_but_shard(text, options));
    fuzz::require(studies::options_of(studies::unfinished_summary(text)).sigmas == options.sigmas, "the same study");
    studies::validate(options);
  });
  fuzz::may_refuse([&] { static_cast<void>(studies::difference_but_shard(text, studies::SweepOptions())); });
  return 0;
}
