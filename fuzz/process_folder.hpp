// A folder for readers of folders, for the life of the process.
#pragma once

#include <stdlib.h>
#include <filesystem>
#include <string>

#include "holds.hpp"

namespace consimd::fuzz {

/// Makes an empty folder, in memory where there is such a place, and removes it at exit. Once a process.
inline std::filesystem::path make_process_folder() {
  namespace fs = std::filesystem;
  const fs::path memory = "/dev/shm";
  static std::string made =
      ((fs::is_directory(memory) ? memory : fs::temp_directory_path()) / "consimd-fuzz-XXXXXX").string();
  require(mkdtemp(made.data()) != nullptr, "a folder of its own");
  require(std::atexit([] { fs::remove_all(made); }) == 0, "a folder that is removed");
  return made;
}

}  // namespace consimd::fuzz
