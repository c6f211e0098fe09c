#include "files/csv_file.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>

namespace consimd::studies {

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) throw std::runtime_error(fmt::format("{}: cannot read", path.string()));
  return text;
}

void for_each_row(const std::filesystem::path& path, std::string_view text, std::string_view columns,
                  const std::function<void(std::string_view)>& take) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    try {
      if (number > 1) {
        take(line);
      } else if (line != columns) {
        throw std::invalid_argument("not the header of this table");
      }
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(fmt::format("{}:{}: {}; --fresh starts over", path.string(), number, error.what()));
    }
  }
}

void for_each_whole_row(const std::filesystem::path& path, std::string_view columns,
                        const std::function<void(std::string_view)>& take) {
  const std::string text = read_text(path);
  const std::size_t whole = text.rfind('\n') + 1;  // npos + 1 is 0: no whole line
  for_each_row(path, std::string_view(text).substr(0, whole), columns, take);
  std::filesystem::resize_file(path, whole);
}

}  // namespace consimd::studies
