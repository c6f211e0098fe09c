// Files of correspondences.
#include <consimd/synth/problem_files.hpp>

#include <algorithm>
#include <cmath>

#include "byte_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace consimd;
  const fuzz::ByteFile file(data, size);
  fuzz::may_refuse([&] {
    const Correspondences read = synth::read_correspondences(file.path());
    fuzz::require(read.size() >= 3, "three rows or an error");
    const CorrespondenceView view = read.view();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 0; k < view.padded_size(); ++k) {
        const bool is_near = k < view.size() && !std::ranges::binary_search(read.far_rows(), k);
        fuzz::require(std::isfinite(view.source(axis)[k]) == is_near, "finite rows, far ones and padding NaN");
        fuzz::require(std::isfinite(view.target(axis)[k]) == is_near, "finite rows, far ones and padding NaN");
      }
    }
  });
  return 0;
}
