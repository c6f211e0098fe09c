#include <consimd/synth/pending_file.hpp>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace consimd::synth {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = ".consimd-";
constexpr std::string_view kSuffix = ".part";
constexpr std::size_t kDigits = 16;

[[noreturn]] void fail(const fs::path& path, int error) {
  throw std::runtime_error(path.string() + ": cannot write: " + std::generic_category().message(error));
}

std::string unpredictable_name() {
  std::random_device source;
  const std::uint64_t number = std::uint64_t{source()} << 32 | source();
  char digits[kDigits];
  const std::to_chars_result end = std::to_chars(digits, digits + kDigits, number, 16);
  std::string name(kPrefix);
  name.append(kDigits - static_cast<std::size_t>(end.ptr - digits), '0').append(digits, end.ptr);
  return name.append(kSuffix);
}

bool is_pending_name(std::string_view name) {
  return name.size() == kPrefix.size() + kDigits + kSuffix.size() && name.starts_with(kPrefix) &&
         name.ends_with(kSuffix);
}

/// Whether the file still has a name; another process may have taken it for abandoned before it was locked.
bool is_linked(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 && status.st_nlink > 0;
}

}  // namespace

PendingFile::PendingFile(fs::path path, std::string_view content) : path_(std::move(path)) {
  create();
  try {
    append(content);
  } catch (const std::runtime_error&) {
    discard();
    throw;
  }
}

PendingFile::~PendingFile() { discard(); }

void PendingFile::create() {
  for (;;) {
    temporary_ = path_.parent_path() / unpredictable_name();
    descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno == EEXIST) continue;
    if (descriptor_ < 0) fail(path_, errno);
    // A file system without locks makes no difference here, but nothing is removed as abandoned there.
    const bool taken = flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!taken && is_linked(descriptor_)) return;
    close(std::exchange(descriptor_, -1));
  }
}

void PendingFile::append(std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor_, content.data(), content.size());
    if (written < 0 && errno != EINTR) fail(path_, errno);
    if (written > 0) content.remove_prefix(static_cast<std::size_t>(written));
  }
}

void PendingFile::commit() {
  // Some file systems tell of a full disk only when a descriptor is closed; this one must stay open for its lock.
  const int second = dup(descriptor_);
  if (second >= 0 && close(second) != 0) fail(path_, errno);
  std::error_code error;
  fs::rename(temporary_, path_, error);
  if (error) fail(path_, error.value());
  temporary_.clear();
}

void PendingFile::discard() noexcept {
  if (descriptor_ < 0) return;
  if (!temporary_.empty()) unlink(temporary_.c_str());
  close(std::exchange(descriptor_, -1));
}

void remove_abandoned_files(const fs::path& folder) noexcept {
  try {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder)) {
      if (!is_pending_name(entry.path().filename().string())) continue;
      const int descriptor = open(entry.path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
      if (descriptor < 0) continue;
      if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) unlink(entry.path().c_str());
      close(descriptor);
    }
  } catch (const std::exception&) {
    return;  // What cannot be cleaned up is no reason to fail.
  }
}

}  // namespace consimd::synth
