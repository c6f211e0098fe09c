#include <consimd/studies/replace_file.hpp>

#include <stdexcept>

#include <gtest/gtest.h>

#include "temporary_folder.hpp"

namespace consimd::studies {
namespace {

using test::TemporaryFolder;
using test::text_of;
using test::write_text;

namespace fs = std::filesystem;

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(ReplaceFile, ReplacesTheWholeFileAndLeavesNothingElse) {
  const TemporaryFolder folder;
  replace_file(folder / "a", "long content");
  replace_file(folder / "a", "short");
  EXPECT_EQ(text_of(folder / "a"), "short");
  EXPECT_EQ(entries(folder / ""), 1u);
}

TEST(ReplaceFile, WritesThroughALink) {
  const TemporaryFolder folder;
  write_text(folder / "real", "old");
  fs::create_symlink("real", folder / "link");
  replace_file(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(text_of(folder / "real"), "new");
}

TEST(ReplaceFile, WritesToADeviceInPlace) {
  const TemporaryFolder folder;
  fs::create_symlink("/dev/null", folder / "null");
  require_replaceable(folder / "null");
  replace_file(folder / "null", "gone");
  EXPECT_TRUE(fs::is_character_file(folder / "null"));
}

TEST(ReplaceFile, RefusesWhatCannotBeWritten) {
  const TemporaryFolder folder;
  write_text(folder / "file", "");
  for (const fs::path& path : {folder / "missing/a", folder / "file/a", folder / ""}) {
    EXPECT_THROW(require_replaceable(path), std::runtime_error) << path;
    EXPECT_THROW(replace_file(path, "x"), std::runtime_error) << path;
  }
  EXPECT_THROW(require_writable_folder(folder / "file"), std::runtime_error);
  EXPECT_THROW(require_writable_folder(folder / "file/folder"), std::runtime_error);
  EXPECT_EQ(entries(folder / ""), 1u);
}

TEST(ReplaceFile, CheckingLeavesNoTrace) {
  const TemporaryFolder folder;
  require_replaceable(folder / "a");
  require_writable_folder(folder / "new/deep");
  EXPECT_EQ(entries(folder / ""), 1u);
  EXPECT_EQ(entries(folder / "new/deep"), 0u);
}

}  // namespace
}  // namespace consimd::studies
