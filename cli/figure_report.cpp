#include "figure_report.hpp"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/studies/figures.hpp>

#include "standard_streams.hpp"

namespace consimd::cli {
namespace {

std::filesystem::path program() {
  std::error_code unknown;
  return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

}  // namespace

void draw_and_name_figures(std::string_view script, std::string_view folder,
                           const std::vector<std::string_view>& names) {
  flush_standard_output();
  try {
    studies::draw_figures(script, folder, program());
    std::vector<std::string> files;
    files.reserve(names.size());
    for (const std::string_view name : names) files.push_back(fmt::format("{}/{}.svg", folder, name));
    fmt::print("figure{}: {} (and .png)\n", files.size() == 1 ? "" : "s", fmt::join(files, ", "));
  } catch (const std::runtime_error& error) {
    tell("consimd: figures not drawn: {}\n", error.what());
  }
}

}  // namespace consimd::cli
