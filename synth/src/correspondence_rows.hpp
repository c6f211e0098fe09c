// Which columns of a table of numbers are a correspondence.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

namespace consimd::synth {

/// Source x y z and target x y z a row, row-major.
struct CorrespondenceRows {
  std::vector<double> values;

  [[nodiscard]] std::size_t size() const noexcept { return values.size() / 6; }
};

/// Reads three rows or more. chosen: the six columns, counted from 1, or none, where the file must tell: by having six,
/// by their names, or by an index before them. Throws std::runtime_error that names the file, and the line where there
/// is one.
[[nodiscard]] CorrespondenceRows read_correspondence_rows(const std::filesystem::path& path,
                                                          std::span<const std::size_t> chosen);

}  // namespace consimd::synth
