// Small text files of data sets: lines of words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/poses/rigid_fit.hpp>

namespace consimd::studies {

struct TextRow {
  std::size_t line = 0;  ///< counted from 1
  std::vector<std::string> words;
};

/// A file whose rows are taken one after the other. Faults are std::runtime_errors "FILE:LINE: what".
class TextRows {
 public:
  /// Words are separated by any of `separators`; blanks around them are dropped, and so are comments from '#' on and
  /// empty lines. Where a comma or semicolon separates, words may be empty.
  explicit TextRows(std::filesystem::path path, std::string_view separators = " \t");

  [[nodiscard]] const std::vector<TextRow>& rows() const noexcept { return rows_; }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

  /// A finite number.
  [[nodiscard]] double number(const TextRow& row, std::size_t word) const;
  [[nodiscard]] std::uint32_t whole_number(const TextRow& row, std::size_t word) const;
  void require_words(const TextRow& row, std::size_t count) const;
  /// Twelve or sixteen numbers from that word on, row by row, [R t] and perhaps 0 0 0 1.
  [[nodiscard]] RigidTransform pose(const TextRow& row, std::size_t first) const;
  /// The same from `count` rows of four numbers, from that row on.
  [[nodiscard]] RigidTransform pose_of_rows(std::size_t first, std::size_t count) const;

  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail(const TextRow& row, const std::string& what) const;

 private:
  [[nodiscard]] RigidTransform checked_pose(const TextRow& row, const std::vector<double>& numbers) const;

  std::filesystem::path path_;
  std::vector<TextRow> rows_;
};

}  // namespace consimd::studies
