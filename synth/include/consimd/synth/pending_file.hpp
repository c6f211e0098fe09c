// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

/// A file with its content that does not have its name yet: `commit` gives it the name, else it disappears.
///
/// Until then it lies in the same folder under a name that nobody can guess, newly made: what lies there already, a
/// link above all, is never written to. It is locked, so that `remove_abandoned_files` knows it from one whose writer
/// was killed. Functions throw std::runtime_error that names `path` and says why.
class PendingFile {
 public:
  PendingFile(std::filesystem::path path, std::string_view content);
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /// Adds to the end.
  void append(std::string_view content);

  /// The name that it has until then.
  [[nodiscard]] const std::filesystem::path& temporary() const noexcept { return temporary_; }

  /// Replaces what has the name `path`, a link itself and not what it leads to.
  void commit();

 private:
  void create();
  void discard() noexcept;

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
};

/// Removes the pending files in `folder` whose writers ended without a chance to do so. Does nothing where the folder
/// cannot be read or its file system knows no locks.
void remove_abandoned_files(const std::filesystem::path& folder) noexcept;

}  // namespace synth
}  // namespace consimd
