#include <consimd/studies/replace_file.hpp>

#include <cerrno>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include <consimd/synth/pending_file.hpp>

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& path, int error) {
  throw std::runtime_error(fmt::format("{}: cannot write: {}", path.string(), std::generic_category().message(error)));
}

void write_in_place(const fs::path& path, std::string_view content) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(content.data(), static_cast<std::streamsize>(content.size()));
  file.close();
  if (!file) fail(path, errno != 0 ? errno : EIO);
}

/// The file behind `path`, and whether it is to be written in place.
struct Target {
  fs::path path;
  bool in_place;
};

Target resolve(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) fail(path, EISDIR);
  if (!fs::exists(status)) return {path, false};
  if (!fs::is_regular_file(status)) return {path, true};
  const fs::path real = fs::canonical(path, error);
  return {error ? path : real, false};
}

/// Makes and removes a file in the folder of `path`, whose name an error tells, and with it what killed processes left.
void probe(const fs::path& path) {
  const synth::PendingFile file(path, {});
  synth::remove_abandoned_files(path.parent_path());
}

}  // namespace

void replace_file(const fs::path& path, std::string_view content) {
  const Target target = resolve(path);
  if (target.in_place) return write_in_place(target.path, content);
  synth::PendingFile file(target.path, content);
  file.commit();
}

void require_replaceable(const fs::path& path) {
  const Target target = resolve(path);
  if (!target.in_place) probe(target.path);
}

void require_writable_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(folder, error.value());
  probe(folder / "");
}

}  // namespace consimd::studies
