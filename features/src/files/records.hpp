// Points in the bytes of a file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/features/cloud_files.hpp>

namespace consimd::features::detail {

/// A fault of a file; whoever knows its name puts it in front.
class FileFault : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// x y z of each point.
using Coordinates = std::vector<std::array<double, 3>>;

enum class NumberType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

[[nodiscard]] std::size_t size_of(NumberType type) noexcept;

/// Where a coordinate of the first point is, and how far it is to that of the next.
struct Column {
  std::size_t offset = 0;
  std::size_t stride = 0;
  NumberType type = NumberType::float32;
};

/// `count` points out of `bytes`, of the machine's byte order or the other. Throws FileFault where the bytes end before
/// the points do.
[[nodiscard]] Coordinates read_columns(std::string_view bytes, const std::array<Column, 3>& columns, std::size_t count,
                                       bool swapped);

/// Throws FileFault unless `bytes` hold that many records of `size` bytes.
void require_records(std::string_view bytes, std::size_t count, std::size_t size);

/// A whole number. Throws FileFault that says what it is of.
[[nodiscard]] std::size_t parse_count(std::string_view word, std::string_view of);

/// Ends of lines as old Macs wrote them, alone or among others, as line feeds; nothing where there is none.
[[nodiscard]] std::optional<std::string> with_line_feeds(std::string_view text);

/// The words of a line, between blanks.
[[nodiscard]] std::vector<std::string_view> words_between_blanks(std::string_view line);

/// The words of a line, between semicolons, commas or tabs where it has any, without its comment.
[[nodiscard]] std::vector<std::string_view> words_of_row(std::string_view line);

// The forms of files, each from its whole contents. They throw FileFault.
[[nodiscard]] Coordinates read_ply(std::string_view bytes);
[[nodiscard]] Coordinates read_pcd(std::string_view bytes);
[[nodiscard]] Coordinates read_npy(std::string_view bytes);
[[nodiscard]] Coordinates read_npz(std::string_view bytes);
[[nodiscard]] Coordinates read_las(std::string_view bytes);
[[nodiscard]] Coordinates read_kitti(std::string_view bytes);
/// chosen: which of a line's words are x, y and z, counted from 0; else the text tells.
[[nodiscard]] Coordinates read_point_text(std::string_view text,
                                          const std::optional<std::array<std::size_t, 3>>& chosen = std::nullopt);

/// Matched points of an .npz: the arrays src_corr_points and ref_corr_points, as long as one another; of an .npy: N
/// x 6.
[[nodiscard]] std::array<Coordinates, 2> read_npz_matches(std::string_view bytes);
[[nodiscard]] std::array<Coordinates, 2> read_npy_matches(std::string_view bytes);

/// `count` lines of numbers; columns: which of a line's are x, y and z; lines start after line `before` of the file.
/// Throws FileFault "LINE: what".
[[nodiscard]] Coordinates read_number_lines(std::string_view text, const std::array<std::size_t, 3>& columns,
                                            std::size_t count, std::size_t before);

/// Undoes LZF compression. Throws FileFault unless exactly `size` bytes come out.
[[nodiscard]] std::string decompress_lzf(std::string_view compressed, std::size_t size);

/// The whole file. Throws std::runtime_error "FILE: cannot read: why".
[[nodiscard]] std::string contents(const std::filesystem::path& path);

/// The points of a file in any of the forms, by its beginning or its ending. columns: as `read_cloud` has them. Throws
/// FileFault, and std::invalid_argument on a column of 0.
[[nodiscard]] Coordinates read_points(std::string_view bytes, const std::filesystem::path& path,
                                      const std::optional<TextColumns>& columns = std::nullopt);

/// `fault` with the name of its file in front, as "FILE: what" or, of text, "FILE:LINE: what".
[[nodiscard]] std::runtime_error named(const std::filesystem::path& path, const FileFault& fault);

}  // namespace consimd::features::detail
