// case.json.
#include <consimd/studies/case_folder.hpp>

#include <cmath>

#include "byte_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace consimd;
  const fuzz::ByteFile file(data, size);
  fuzz::may_refuse([&] {
    const studies::CaseFile read = studies::read_case_file(file.path());
    fuzz::require(std::isfinite(read.noise_bound) && read.noise_bound > 0.0, "a noise bound above 0");
    const studies::PoseLimits limits = read.limits(file.path());
    fuzz::require(limits.rotation_deg > 0.0 && limits.translation > 0.0, "limits above 0");
  });
  return 0;
}
