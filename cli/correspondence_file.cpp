#include "correspondence_file.hpp"

#include <stdexcept>

#include <fmt/format.h>

#include "number_table.hpp"

namespace consimd::cli {

Correspondences read_correspondences(const std::filesystem::path& path) {
  const NumberTable table = read_number_table(path, 6);
  if (table.rows() < 3) {
    throw std::runtime_error(
        fmt::format("{}: expected at least 3 correspondences, got {}", path.string(), table.rows()));
  }
  const PointSpan<double> source{table.values.data(), table.rows(), 6, 1};
  const PointSpan<double> target{table.values.data() + 3, table.rows(), 6, 1};
  return {source, target};
}

}  // namespace consimd::cli
