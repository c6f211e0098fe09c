#include <consimd/features/cloud_files.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "files/records.hpp"
#include "text/words.hpp"

namespace consimd::features {
namespace {

/// What is left of a stream. `expected`: how much that may be.
std::string rest_of(std::istream& stream, std::size_t expected) {
  constexpr std::size_t kLeast = std::size_t{1} << 12U;
  std::string bytes;
  // The byte more than expected shows the end. What is longer comes in blocks as large as what there is.
  for (std::size_t block = std::max(expected + 1, kLeast); stream; block = bytes.size()) {
    const std::size_t before = bytes.size();
    bytes.resize(before + block);
    stream.read(bytes.data() + before, static_cast<std::streamsize>(block));
    bytes.resize(before + static_cast<std::size_t>(stream.gcount()));
  }
  return bytes;
}

}  // namespace

namespace detail {

std::string contents(const std::filesystem::path& path) {
  if (path == "-") return rest_of(std::cin, 0);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw std::runtime_error(path.string() + ": is a folder, expected a file");
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw std::runtime_error(path.string() + ": cannot read: " + std::generic_category().message(errno));
  }
  const std::uintmax_t size = std::filesystem::file_size(path, ignored);  // of what is no file: the largest number
  return rest_of(file, ignored ? 0 : static_cast<std::size_t>(size));
}

namespace {

using Reader = Coordinates (*)(std::string_view);

/// The reader of a form that says where its coordinates are, by a file's beginning or ending; null of other text.
Reader reader_of_form(std::string_view bytes, const std::string& form) {
  if (form == ".ply" || bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return read_ply;
  if (form == ".pcd" || bytes.starts_with("# .PCD") || bytes.starts_with("VERSION ")) return read_pcd;
  if (form == ".npy" || bytes.starts_with("\x93NUMPY")) return read_npy;
  if (form == ".npz" || bytes.starts_with("PK\3\4")) return read_npz;
  if (bytes.starts_with("LASF")) return read_las;
  if (form == ".bin") return read_kitti;
  return nullptr;
}

}  // namespace

Coordinates read_points(std::string_view bytes, const std::filesystem::path& path,
                        const std::optional<TextColumns>& columns) {
  if (columns && std::ranges::find(*columns, std::size_t{0}) != columns->end()) {
    throw std::invalid_argument("columns are counted from 1");
  }
  if (const Reader reader = reader_of_form(bytes, text::lower(path.extension().string()))) {
    if (columns) throw FileFault("columns are chosen of plain text alone");
    return reader(bytes);
  }
  if (bytes.starts_with("ASTM-E57")) {
    throw FileFault("an E57 file, which is not read: convert it with 'pdal translate FILE.e57 FILE.las'");
  }
  if (bytes.starts_with("\x1F\x8B")) {
    throw FileFault("compressed by gzip, which is not read: unpack it with 'gunzip', or read 'gunzip -c FILE' as '-'");
  }
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) {
    throw FileFault("UTF-16 text, expected UTF-8 or ASCII: convert it with 'iconv -f UTF-16 -t UTF-8'");
  }
  if (bytes.find('\0') != std::string_view::npos) {
    throw FileFault("not a cloud: neither PLY, PCD, NPY, NPZ, LAS or text, nor a .bin of KITTI's form");
  }
  if (!columns) return read_point_text(bytes);
  return read_point_text(bytes, std::array{(*columns)[0] - 1, (*columns)[1] - 1, (*columns)[2] - 1});
}

std::runtime_error named(const std::filesystem::path& path, const FileFault& fault) {
  const std::string what = fault.what();
  // A fault of text begins with its line.
  const bool has_line =
      !what.empty() && what[0] >= '0' && what[0] <= '9' && what.find(": ") == what.find_first_not_of("0123456789");
  return std::runtime_error(path.string() + (has_line ? ":" : ": ") + what);
}

}  // namespace detail

Cloud read_cloud(const std::filesystem::path& path, std::optional<double> missing,
                 const std::optional<TextColumns>& columns) {
  try {
    const detail::Coordinates points = detail::read_points(detail::contents(path), path, columns);
    return Cloud(PointSpan<double>::interleaved(points.empty() ? nullptr : points.front().data(), points.size()),
                 missing);
  } catch (const detail::FileFault& fault) {
    throw detail::named(path, fault);
  }
}

std::string moved_ply(const Cloud& cloud, const RigidTransform& motion) {
  const std::size_t rows = cloud.size() + cloud.left_out();
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(rows) +
                     "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
  const std::size_t begin = text.size();
  text.resize(begin + 24 * rows);
  const auto write = [&](std::size_t row, const Eigen::Vector3d& p) {
    for (std::size_t c = 0; c < 3; ++c) {
      auto bits = std::bit_cast<std::uint64_t>(p[static_cast<Eigen::Index>(c)]);
      for (std::size_t byte = 0; byte < 8; ++byte, bits >>= 8U) {
        text[begin + 24 * row + 8 * c + byte] = static_cast<char>(static_cast<unsigned char>(bits & 0xffU));
      }
    }
  };
  if (cloud.left_out() > 0) {
    const Eigen::Vector3d nowhere = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t row = 0; row < rows; ++row) write(row, nowhere);
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    write(cloud.input_row(i), motion * Eigen::Vector3d(cloud.point(i).data()));
  }
  return text;
}

}  // namespace consimd::features
