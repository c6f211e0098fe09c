#include <consimd/features/cloud_files.hpp>

#include <cerrno>
#include <fstream>
#include <iostream>
#include <iterator>
#include <system_error>

#include "files/records.hpp"

namespace consimd::features {
namespace {

std::string contents(const std::filesystem::path& path) {
  if (path == "-") return {std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()};
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw std::runtime_error(path.string() + ": is a folder, expected a file");
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw std::runtime_error(path.string() + ": cannot read: " + std::generic_category().message(errno));
  }
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

detail::Coordinates coordinates(std::string_view bytes, const std::filesystem::path& path) {
  const std::filesystem::path form = path.extension();
  if (form == ".ply" || bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return detail::read_ply(bytes);
  if (form == ".pcd" || bytes.starts_with("# .PCD") || bytes.starts_with("VERSION ")) return detail::read_pcd(bytes);
  if (form == ".npy" || bytes.starts_with("\x93NUMPY")) return detail::read_npy(bytes);
  if (form == ".bin") return detail::read_kitti(bytes);
  if (bytes.find('\0') != std::string_view::npos) {
    throw detail::FileFault("not a cloud: neither PLY, PCD, NPY or text, nor a .bin of KITTI's form");
  }
  return detail::read_point_text(bytes);
}

}  // namespace

Cloud read_cloud(const std::filesystem::path& path, std::optional<double> missing) {
  try {
    const std::string bytes = contents(path);
    const detail::Coordinates points = coordinates(bytes, path);
    return Cloud(PointSpan<double>::interleaved(points.empty() ? nullptr : points.front().data(), points.size()),
                 missing);
  } catch (const detail::FileFault& fault) {
    const std::string what = fault.what();
    // A fault of text begins with its line.
    const bool has_line =
        !what.empty() && what[0] >= '0' && what[0] <= '9' && what.find(": ") == what.find_first_not_of("0123456789");
    throw std::runtime_error(path.string() + (has_line ? ":" : ": ") + what);
  }
}

}  // namespace consimd::features
