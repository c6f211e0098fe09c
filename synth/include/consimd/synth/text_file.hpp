// Reading text files.
#pragma once

#include <filesystem>
#include <string>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

/// All of a file, of standard input where `path` is "-". Throws std::runtime_error that names it and says why it cannot
/// be read; a folder cannot.
[[nodiscard]] std::string read_text(const std::filesystem::path& path);

}  // namespace synth
}  // namespace consimd
