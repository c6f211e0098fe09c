// Files of clouds and of matches that hold points of two.
#include <consimd/features/cloud_files.hpp>
#include <consimd/features/correspondence_files.hpp>

#include "byte_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace consimd;
  const fuzz::ByteFile file(data, size);
  // Deflated points take a bit each at least.
  fuzz::may_refuse([&] {
    const Cloud cloud = features::read_cloud(file.path());
    fuzz::require(cloud.size() <= 1032 * size, "no more points than bytes");
  });
  fuzz::may_refuse([&] {
    const features::MatchedPoints matches = features::read_npz_matches(file.path());
    fuzz::require(matches.source.size() == matches.target.size(), "as many points of both");
  });
  return 0;
}
