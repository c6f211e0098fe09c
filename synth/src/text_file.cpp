#include <consimd/synth/text_file.hpp>

#include <cerrno>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace consimd::synth {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = std::size_t{1} << 16U;

[[noreturn]] void fail(const fs::path& path, int error) {
  throw std::runtime_error(path.string() + ": cannot read: " + std::generic_category().message(error));
}

}  // namespace

std::string read_text(const fs::path& path) {
  if (path == "-") return {std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()};
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw std::runtime_error(path.string() + ": is a folder, expected a file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, errno);
  std::string text;
  std::vector<char> block(kBlock);
  do {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
  } while (file);
  if (file.bad()) fail(path, errno != 0 ? errno : EIO);  // a disk or a network that fails, not the file's end
  return text;
}

}  // namespace consimd::synth
