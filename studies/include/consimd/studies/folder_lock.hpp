// One process at a time writes to a folder.
#pragma once

#include <filesystem>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Holds a folder until its end, or that of the process. Where the file system knows no locks it holds nothing.
class FolderLock {
 public:
  /// Throws std::runtime_error that names the folder if it is held already.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace studies
}  // namespace consimd
