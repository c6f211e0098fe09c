// Arrays by name, as NumPy packs them: a ZIP archive of .npy files.
#include <algorithm>

#include "files/records.hpp"
#include "files/zip.hpp"
#include "text/words.hpp"

namespace consimd::features::detail {
namespace {

constexpr std::string_view kEnding = ".npy";

std::string names_of(const std::vector<ZipEntry>& entries) {
  std::string names;
  for (const ZipEntry& entry : entries) {
    if (!entry.name.ends_with(kEnding)) continue;
    names.append(names.empty() ? "" : ", ")
        .append(text::shown(entry.name.substr(0, entry.name.size() - kEnding.size())));
  }
  return names.empty() ? "no array" : names;
}

const ZipEntry* find(const std::vector<ZipEntry>& entries, std::string_view name) {
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const ZipEntry& entry) {
    return entry.name.size() == name.size() + kEnding.size() && entry.name.starts_with(name) &&
           entry.name.ends_with(kEnding);
  });
  return found == entries.end() ? nullptr : &*found;
}

Coordinates array_of(const ZipEntry& entry) {
  try {
    return read_npy(unpacked(entry));
  } catch (const FileFault& fault) {
    const std::string what = fault.what();
    const std::string name = text::shown(entry.name);
    throw FileFault(what.starts_with(name) ? what : name + ": " + what);
  }
}

}  // namespace

Coordinates read_npz(std::string_view bytes) {
  const std::vector<ZipEntry> entries = zip_entries(bytes);
  for (const std::string_view name : {"points", "xyz", "pcd"}) {
    if (const ZipEntry* entry = find(entries, name)) return array_of(*entry);
  }
  if (entries.size() == 1) return array_of(entries.front());
  throw FileFault("expected an array named points, xyz or pcd, or a single one, got " + names_of(entries));
}

std::array<Coordinates, 2> read_npz_matches(std::string_view bytes) {
  const std::vector<ZipEntry> entries = zip_entries(bytes);
  std::array<Coordinates, 2> sides;
  constexpr std::array<std::string_view, 2> kNames{"src_corr_points", "ref_corr_points"};
  for (std::size_t side = 0; side < 2; ++side) {
    const ZipEntry* entry = find(entries, kNames[side]);
    if (entry == nullptr) {
      throw FileFault("expected the arrays src_corr_points and ref_corr_points, got " + names_of(entries));
    }
    sides[side] = array_of(*entry);
  }
  if (sides[0].size() != sides[1].size()) {
    throw FileFault(std::to_string(sides[0].size()) + " src_corr_points and " + std::to_string(sides[1].size()) +
                    " ref_corr_points, expected as many of both");
  }
  return sides;
}

}  // namespace consimd::features::detail
