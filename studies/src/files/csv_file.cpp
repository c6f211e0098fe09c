#include "files/csv_file.hpp"

#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "text/words.hpp"

namespace consimd::studies {

namespace {

void take_row(const std::filesystem::path& path, std::size_t number, std::string_view line, std::string_view columns,
              const std::function<void(std::string_view)>& take) {
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

}  // namespace

void for_each_row(const std::filesystem::path& path, std::string_view text, std::string_view columns,
                  const std::function<void(std::string_view)>& take) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    take_row(path, number, text::take_line(text), columns, take);
  }
}

void for_each_whole_row(const std::filesystem::path& path, std::string_view columns,
                        const std::function<void(std::string_view)>& take) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("{}: cannot read", path.string()));
  std::uintmax_t whole = 0;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line) && !file.eof(); ++number) {
    take_row(path, number, line, columns, take);
    whole += line.size() + 1;
  }
  if (file.bad()) throw std::runtime_error(fmt::format("{}: cannot read to its end", path.string()));
  file.close();
  std::filesystem::resize_file(path, whole);
}

}  // namespace consimd::studies
