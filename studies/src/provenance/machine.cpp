#include <sys/utsname.h>
#include <fstream>
#include <thread>

#include <fmt/format.h>

#include <consimd/studies/build_info.hpp>

namespace consimd::studies {
namespace {

std::string cpu_model() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    const std::size_t value = line.find(": ");
    if (line.starts_with("model name") && value != std::string::npos) return line.substr(value + 2);
  }
  return "unknown";
}

}  // namespace

Machine this_machine() {
  utsname name{};
  const bool known = uname(&name) == 0;
  return {cpu_model(), known ? fmt::format("{} {} {}", name.sysname, name.release, name.machine) : "unknown",
          std::thread::hardware_concurrency()};
}

}  // namespace consimd::studies
