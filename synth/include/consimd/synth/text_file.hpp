// Reading text files.
#pragma once

#include <filesystem>
#include <string>

#pragma GCC visibility push(default)

namespace consimd::synth {

/// All of a file, of standard input where `path` is "-". Throws std::runtime_error that names it and says why it cannot
/// be read; a folder cannot.
[[nodiscard]] std::string read_text(const std::filesystem::path& path);

}  // namespace consimd::synth

#pragma GCC visibility pop
