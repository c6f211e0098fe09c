// What this program was built from and what it runs on: numbers mean little without them.
#pragma once

#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

struct BuildInfo {
  std::string_view version;
  std::string_view commit;    ///< "unknown" outside a git checkout
  std::string_view compiler;  ///< "GNU 12.2.0"
  std::string_view flags;     ///< of ordinary sources; kernel sources add those of their instruction set
  std::string_view build_type;
};

[[nodiscard]] const BuildInfo& build_info() noexcept;

struct Machine {
  std::string cpu;     ///< model name; "unknown" where the system does not tell
  std::string system;  ///< "Linux 6.1.0 x86_64"
  unsigned hardware_threads = 0;
};

[[nodiscard]] Machine this_machine();

}  // namespace studies
}  // namespace consimd
