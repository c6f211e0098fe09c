// A table of text, and how it is written.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

struct TextTable {
  std::string name;  ///< of its files
  std::string title;
  std::vector<std::string> caption;  ///< paragraphs
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< as many cells as columns; no commas
};

/// Title, caption and a Markdown table whose columns are aligned, so that it reads as well in a terminal.
[[nodiscard]] std::string to_markdown(const TextTable& table);

/// The columns and rows alone.
[[nodiscard]] std::string to_csv(const TextTable& table);

}  // namespace studies
}  // namespace consimd
