// Tables of a study on disk.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace consimd::studies {

/// Calls `take` with every line of `text` but the first, which must be `columns`. A std::invalid_argument that it
/// throws of a bad row comes out as a std::runtime_error that names the file, the line and --fresh as the remedy.
void for_each_row(const std::filesystem::path& path, std::string_view text, std::string_view columns,
                  const std::function<void(std::string_view)>& take);

/// As above for the rows of a table that grows by whole lines; a last line that a crash cut short is dropped, on disk
/// too.
void for_each_whole_row(const std::filesystem::path& path, std::string_view columns,
                        const std::function<void(std::string_view)>& take);

}  // namespace consimd::studies
