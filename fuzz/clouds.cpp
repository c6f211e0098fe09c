// Files of clouds and of matches between two.
#include <consimd/features/cloud_files.hpp>
#include <consimd/features/correspondence_files.hpp>

#include <optional>
#include <string_view>

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
    const Cloud cloud = features::read_cloud(file.path(), std::nullopt, features::TextColumns{3, 1, 2});
    fuzz::require(6 * cloud.size() <= size + 1, "no more points than lines of three numbers");
  });
  fuzz::may_refuse([&] {
    const features::MatchedPoints matches = features::read_array_matches(file.path());
    fuzz::require(matches.source.size() == matches.target.size(), "as many points of both");
  });
  // What names rows of two clouds, here of three points each.
  static constexpr std::string_view kRows = "0 0 0\n1 0 0\n0 1 0\n";
  static const fuzz::ByteFile rows(reinterpret_cast<const std::uint8_t*>(kRows.data()), kRows.size());
  fuzz::may_refuse([&] {
    const features::MatchedPoints matches = features::read_indexed_matches(rows.path(), rows.path(), file.path());
    fuzz::require(matches.source.size() == matches.target.size(), "as many points of both");
    fuzz::require(4 * matches.source.size() <= size + 1, "no more matches than lines");
  });
  return 0;
}
