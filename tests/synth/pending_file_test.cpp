#include <consimd/synth/pending_file.hpp>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <unistd.h>
#include <csignal>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "temporary_folder.hpp"

namespace consimd::synth {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using test::text_of;
using test::write_text;

std::set<std::string> names(const fs::path& folder) {
  std::set<std::string> result;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) result.insert(entry.path().filename());
  return result;
}

/// Writes beyond so many bytes of a file fail while this lives, as on a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(PendingFile, HasItsNameAfterCommit) {
  const TemporaryFolder folder;
  PendingFile file(folder / "a", "content");
  EXPECT_FALSE(fs::exists(folder / "a"));
  file.commit();
  EXPECT_EQ(text_of(folder / "a"), "content");
  EXPECT_EQ(names(folder / ""), (std::set<std::string>{"a"}));
}

TEST(PendingFile, DisappearsWithoutCommit) {
  const TemporaryFolder folder;
  { const PendingFile file(folder / "a", "content"); }
  EXPECT_EQ(names(folder / ""), std::set<std::string>());
}

TEST(PendingFile, NamesDoNotRepeat) {
  const TemporaryFolder folder;
  const PendingFile first(folder / "a", ""), second(folder / "a", "");
  EXPECT_EQ(names(folder / "").size(), 2u);
}

TEST(PendingFile, ReplacesALinkAndNotWhatItLeadsTo) {
  const TemporaryFolder folder;
  write_text(folder / "victim", "precious");
  fs::create_symlink("victim", folder / "a");
  PendingFile(folder / "a", "content").commit();
  EXPECT_EQ(text_of(folder / "victim"), "precious");
  EXPECT_FALSE(fs::is_symlink(folder / "a"));
}

TEST(PendingFile, FailuresNameTheFileAndLeaveNothing) {
  const TemporaryFolder folder;
  write_text(folder / "a", "old");
  try {
    const FileSizeLimit limit(10);
    PendingFile(folder / "a", std::string(100, 'x')).commit();
    FAIL() << "a file larger than the limit was written";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).find((folder / "a").string() + ": cannot write: "), 0u) << error.what();
  }
  EXPECT_EQ(text_of(folder / "a"), "old");
  EXPECT_THROW(PendingFile(folder / "missing" / "a", ""), std::runtime_error);
  EXPECT_EQ(names(folder / ""), (std::set<std::string>{"a"}));
}

TEST(AbandonedFiles, AreRemovedAndNoOthers) {
  const TemporaryFolder folder;
  write_text(folder / ".consimd-0123456789abcdef.part", "half");
  write_text(folder / ".consimd-0123.part", "of somebody else");
  write_text(folder / "victim", "precious");
  fs::create_symlink("victim", folder / ".consimd-00000000000000ff.part");
  const PendingFile in_use(folder / "a", "");
  remove_abandoned_files(folder / "");
  const std::set<std::string> left = names(folder / "");
  EXPECT_EQ(left.count(".consimd-0123456789abcdef.part"), 0u);
  EXPECT_EQ(left.size(), 4u);  // the link, the victim, the file of another name, the one in use
  remove_abandoned_files(folder / "missing");
}

}  // namespace
}  // namespace consimd::synth
