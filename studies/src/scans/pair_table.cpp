// Pairs of anybody's scans in a CSV table.
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/synth/problem_files.hpp>

#include "scans/layouts.hpp"
#include "scans/text_rows.hpp"
#include "text/words.hpp"

namespace consimd::studies::detail {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kColumns[] = {
    "source", "target", "pose", "group", "name", "max_rotation_error_deg", "max_translation_error_m"};
constexpr std::size_t kNeeded = 3;

/// Which word of a row a column is.
using Places = std::map<std::string, std::size_t, std::less<>>;

/// Those that the first row names, or the needed three in their order.
Places places_of(const TextRows& file, bool& has_head) {
  const TextRow& head = file.rows().front();
  has_head = std::ranges::find(head.words, kColumns[0]) != head.words.end();
  Places places;
  if (!has_head) {
    for (std::size_t k = 0; k < kNeeded; ++k) places.emplace(kColumns[k], k);
    return places;
  }
  for (std::size_t k = 0; k < head.words.size(); ++k) {
    const std::string& name = head.words[k];
    if (std::ranges::find(kColumns, name) == std::end(kColumns)) {
      file.fail(head, fmt::format("unknown column '{}'; known: {}", name, fmt::join(kColumns, ", ")));
    }
    if (!places.emplace(name, k).second) file.fail(head, fmt::format("column '{}' is there twice", name));
  }
  for (std::size_t k = 0; k < kNeeded; ++k) {
    if (!places.contains(kColumns[k])) file.fail(head, fmt::format("has no column '{}'", kColumns[k]));
  }
  return places;
}

/// A file's name, or 12 or 16 numbers with blanks between them.
RigidTransform pose_of(const TextRows& file, const TextRow& row, const std::string& text) {
  const fs::path path = file.path().parent_path() / text;
  if (std::error_code ignored; fs::exists(path, ignored)) return synth::read_pose(path);
  TextRow numbers{row.line, {}};
  for (const std::string_view word : text::split(text, " \t")) {
    if (!word.empty()) numbers.words.emplace_back(word);
  }
  if (numbers.words.size() == 1) file.fail(row, fmt::format("{}: is missing", path.string()));
  return file.pose(numbers, 0);
}

std::optional<double> limit(const TextRows& file, const TextRow& row, const Places& places, std::string_view column) {
  const auto place = places.find(column);
  if (place == places.end() || row.words[place->second].empty()) return std::nullopt;
  const double value = file.number(row, place->second);
  if (!(value > 0.0)) file.fail(row, fmt::format("{}: expected a number above 0, got {}", column, value));
  return value;
}

}  // namespace

ScanList read_pair_table(const LayoutOptions& options) {
  fs::path path = options.folder;
  if (std::error_code ignored; fs::is_directory(path, ignored)) path /= "pairs.csv";
  require_file(path);
  const TextRows file(path, ",;");
  if (file.rows().empty()) file.fail("lists no pairs");
  bool has_head = false;
  const Places places = places_of(file, has_head);
  const auto word = [&](const TextRow& row, std::string_view column, const std::string& otherwise) {
    const auto place = places.find(column);
    return place == places.end() || row.words[place->second].empty() ? otherwise : row.words[place->second];
  };

  std::map<std::string, ScanGroup> groups;
  std::set<std::pair<std::string, std::string>> names;
  for (std::size_t k = has_head ? 1 : 0; k < file.rows().size(); ++k) {
    const TextRow& row = file.rows()[k];
    file.require_words(row, places.size());
    const std::string name = word(row, "group", name_of(path.parent_path().empty() ? "." : path.parent_path()));
    if (!wanted(options, name)) continue;
    ScanGroup& group = groups[name];
    group.name = group.sequence = name;
    group.provenance = fmt::format("scans of the pairs in {}", path.filename().string());
    ScanPair pair{.name = {}, .source = {}, .target = {}};
    for (const auto& [column, scan] : {std::pair("source", &pair.source), std::pair("target", &pair.target)}) {
      const std::string text = word(row, column, "");
      if (text.empty()) file.fail(row, fmt::format("has no {}", column));
      *scan = path.parent_path() / text;
      if (std::error_code ignored; !fs::exists(*scan, ignored)) {
        file.fail(row, fmt::format("{}: is missing", scan->string()));
      }
    }
    pair.name = word(row, "name", fmt::format("{}-{}", pair.source.stem().string(), pair.target.stem().string()));
    if (!names.emplace(name, pair.name).second) {
      file.fail(row, fmt::format("pair {} is there twice: give each a name of its own in a column 'name'", pair.name));
    }
    pair.T_target_source = pose_of(file, row, word(row, "pose", ""));
    const std::optional<double> rotation = limit(file, row, places, "max_rotation_error_deg");
    const std::optional<double> translation = limit(file, row, places, "max_translation_error_m");
    if (rotation.has_value() != translation.has_value()) {
      file.fail(row, "expected limits of both rotation and translation, or of none");
    }
    if (rotation) pair.limits = {*rotation, *translation};
    group.pairs.push_back(std::move(pair));
  }
  ScanList list;
  for (auto& [name, group] : groups) list.groups.push_back(std::move(group));
  if (list.groups.empty() && options.sequences.empty()) file.fail("lists no pairs");
  return list;
}

}  // namespace consimd::studies::detail
