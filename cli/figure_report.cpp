#include "figure_report.hpp"

#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/studies/figures.hpp>
#include <consimd/studies/replace_file.hpp>
#include <consimd/synth/text_file.hpp>

#include "standard_streams.hpp"

namespace consimd::cli {
namespace {

std::filesystem::path program() {
  std::error_code unknown;
  return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

/// A folder of one's own that goes when this does.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::random_device random;
    do path_ = std::filesystem::temp_directory_path() / fmt::format("consimd-{:08x}{:08x}", random(), random());
    while (!std::filesystem::create_directory(path_));
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  TemporaryFolder(TemporaryFolder&&) = delete;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path path_;
};

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

std::string drawn_as_png(std::string_view drawing) {
  const TemporaryFolder folder;
  studies::replace_file(folder.path() / "picture.svg", drawing);
  try {
    studies::draw_figures(studies::kPictureScript, folder.path(), program());
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("--picture: {}", error.what()));
  }
  return synth::read_text(folder.path() / "picture.png");
}

}  // namespace consimd::cli
