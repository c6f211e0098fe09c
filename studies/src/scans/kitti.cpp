// KITTI odometry (Geiger, Lenz, Urtasun, CVPR 2012) as its site gives it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <consimd/features/point_subset.hpp>

#include "scans/layouts.hpp"
#include "scans/text_rows.hpp"
#include "text/words.hpp"

namespace consimd::studies::detail {
namespace fs = std::filesystem;
namespace {

constexpr PoseLimits kPaperLimits{5.0, 1.0};
constexpr std::uint32_t kPaperPairs = 200;
// At 100 km/h and ten frames a second these are 2.8 m apart: a tenth of the paper's 17 m is more than half of that, so
// that no frame of a whole sequence is left without a partner for it.
constexpr double kDistanceTolerance = 0.1;
// Of the sequences after this one the poses are not published.
constexpr std::string_view kLastWithPoses = "10";

struct Sequence {
  std::string name;
  fs::path folder;
  std::map<std::uint32_t, fs::path> scans = {};  // by frame
  fs::path pose_file = {};
  std::vector<RigidTransform> poses = {};  // of the scanner, to that of frame 0's camera
};

/// The numbers of the frames in a velodyne folder.
std::map<std::uint32_t, fs::path> scans_in(const fs::path& folder) {
  std::map<std::uint32_t, fs::path> scans;
  if (std::error_code ignored; !fs::is_directory(folder, ignored)) {
    throw std::runtime_error(fmt::format("{}: is missing", folder.string()));
  }
  for (fs::path& path : files_in(folder)) {
    const std::string stem = path.stem().string();
    const auto frame = text::number_in<std::uint32_t>(stem);
    if (path.extension() != ".bin" || !frame) continue;
    scans.emplace(*frame, std::move(path));
  }
  if (scans.empty()) throw std::runtime_error(fmt::format("{}: holds no scan NNNNNN.bin", folder.string()));
  return scans;
}

RigidTransform read_calibration(const fs::path& path) {
  require_file(path);
  const TextRows file(path);
  for (const TextRow& row : file.rows()) {
    if (row.words.front() == "Tr:" || row.words.front() == "Tr_velo_to_cam:") return file.pose(row, 1);
  }
  file.fail("has no line 'Tr:', the pose from the scanner to the camera");
}

fs::path pose_file_of(const fs::path& root, const Sequence& sequence) {
  // Others keep the poses with the sequence.
  const fs::path inside = sequence.folder / "poses.txt";
  const fs::path published = root / "poses" / (sequence.name + ".txt");
  std::error_code ignored;
  return !fs::exists(published, ignored) && fs::exists(inside, ignored) ? inside : published;
}

Sequence read_sequence(const fs::path& root, const fs::path& folder) {
  Sequence sequence{.name = folder.filename().string(), .folder = folder};
  sequence.scans = scans_in(folder / "velodyne");
  const RigidTransform T_camera_scanner = read_calibration(folder / "calib.txt");
  sequence.pose_file = pose_file_of(root, sequence);
  require_file(sequence.pose_file);
  const TextRows file(sequence.pose_file);
  for (const TextRow& row : file.rows()) sequence.poses.push_back(file.pose(row, 0) * T_camera_scanner);
  if (const std::uint32_t last = sequence.scans.rbegin()->first; last >= sequence.poses.size()) {
    file.fail(fmt::format("has no pose of frame {}: it ends with frame {}", last,
                          static_cast<std::int64_t>(sequence.poses.size()) - 1));
  }
  return sequence;
}

double distance_between(const Sequence& sequence, std::uint32_t a, std::uint32_t b) {
  return (sequence.poses[a].translation() - sequence.poses[b].translation()).norm();
}

ScanPair pair_of(const Sequence& sequence, std::uint32_t source, std::uint32_t target) {
  return {.name = fmt::format("{:06}-{:06}", source, target),
          .source = sequence.scans.at(source),
          .target = sequence.scans.at(target),
          .T_target_source = sequence.poses[target].inverse() * sequence.poses[source],
          .limits = kPaperLimits};
}

/// The first frame after `target` that is as far away, or the one before it, whichever is nearer to the distance; none
/// within the tolerance.
std::optional<std::uint32_t> partner(const Sequence& sequence, std::uint32_t target, double distance) {
  std::optional<std::uint32_t> best;
  double least = kDistanceTolerance * distance;
  for (auto scan = sequence.scans.upper_bound(target); scan != sequence.scans.end(); ++scan) {
    const double between = distance_between(sequence, scan->first, target);
    if (std::abs(between - distance) <= least) {
      least = std::abs(between - distance);
      best = scan->first;
    }
    if (between >= distance) break;
  }
  return best;
}

std::string distances_there_are(const Sequence& sequence) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const auto& [a, path] : sequence.scans) {
    for (auto b = sequence.scans.upper_bound(a); b != sequence.scans.end(); ++b) {
      least = std::min(least, distance_between(sequence, a, b->first));
      most = std::max(most, distance_between(sequence, a, b->first));
    }
  }
  return most == 0.0 ? "there is one scan" : fmt::format("they are {:.1f} to {:.1f} m apart", least, most);
}

/// The group of a sequence, with pairs still to come.
ScanGroup group_of(const Sequence& sequence) {
  return {.name = "KITTI " + sequence.name,
          .dataset = "KITTI",
          .sequence = sequence.name,
          .provenance = "scans of KITTI odometry",
          .pairs = {}};
}

ScanGroup drawn_pairs(const Sequence& sequence, const LayoutOptions& options, ScanList& list) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> all;
  for (const auto& [target, path] : sequence.scans) {
    if (const auto source = partner(sequence, target, options.distance)) all.emplace_back(*source, target);
  }
  if (all.empty()) {
    throw std::runtime_error(
        fmt::format("{}: no two of its {} scans are {:g} m apart, within a tenth; {}: give another distance or a list "
                    "of pairs",
                    (sequence.folder / "velodyne").string(), sequence.scans.size(), options.distance,
                    distances_there_are(sequence)));
  }
  if (const std::size_t missing = sequence.poses.size() - sequence.scans.size(); missing > 0) {
    std::uint32_t first = 0;
    while (sequence.scans.contains(first)) ++first;
    list.notes.push_back(
        fmt::format("{} of the {} frames of sequence {} have no scan, the first is {:06}: pairs are "
                    "drawn from the others",
                    missing, sequence.poses.size(), sequence.name, first));
  }
  const std::size_t wanted = options.pairs.value_or(kPaperPairs);
  if (all.size() < wanted) {
    list.notes.push_back(fmt::format("sequence {} has {} pair{} at {:g} m, not {}", sequence.name, all.size(),
                                     all.size() == 1 ? "" : "s", options.distance, wanted));
  }
  ScanGroup group = group_of(sequence);
  for (const std::uint32_t row : features::random_subset(all.size(), wanted, options.seed)) {
    group.pairs.push_back(pair_of(sequence, all[row].first, all[row].second));
  }
  group.provenance += fmt::format(", drawn at {:g} m by seed {}", options.distance, options.seed);
  return group;
}

void add_listed_pairs(const fs::path& root, const LayoutOptions& options, ScanList& list) {
  const TextRows file(options.pair_list, " \t,");
  std::map<std::string, std::pair<Sequence, ScanGroup>> groups;
  for (TextRow row : file.rows()) {
    std::erase(row.words, "");  // commas with blanks around them
    file.require_words(row, 3);
    const std::string& name = row.words.front();
    if (!wanted(options, name)) continue;
    auto found = groups.find(name);
    if (found == groups.end()) {
      if (std::error_code ignored; !fs::is_directory(root / "sequences" / name, ignored)) {
        file.fail(row, fmt::format("{}: is missing", (root / "sequences" / name).string()));
      }
      Sequence sequence = read_sequence(root, root / "sequences" / name);
      ScanGroup group = group_of(sequence);
      group.provenance += fmt::format(", pairs of {}", fs::path(options.pair_list).filename().string());
      found = groups.emplace(name, std::pair(std::move(sequence), std::move(group))).first;
    }
    auto& [sequence, group] = found->second;
    const std::uint32_t source = file.whole_number(row, 1), target = file.whole_number(row, 2);
    for (const std::uint32_t frame : {source, target}) {
      if (sequence.scans.contains(frame)) continue;
      file.fail(row, fmt::format("{}: is missing",
                                 (sequence.folder / "velodyne" / fmt::format("{:06}.bin", frame)).string()));
    }
    if (source == target) file.fail(row, "source and target are one scan");
    group.pairs.push_back(pair_of(sequence, source, target));
  }
  if (groups.empty()) file.fail("lists no pairs of these sequences");
  for (auto& [name, found] : groups) list.groups.push_back(std::move(found.second));
}

}  // namespace

ScanList read_kitti(const LayoutOptions& options) {
  // The archives unpack to a folder "dataset".
  std::error_code ignored;
  fs::path root = options.folder;
  if (!fs::is_directory(root / "sequences", ignored) && fs::is_directory(root / "dataset/sequences", ignored)) {
    root /= "dataset";
  }
  if (!fs::is_directory(root / "sequences", ignored)) {
    throw std::runtime_error(fmt::format("{}: is missing", (root / "sequences").string()));
  }
  ScanList list;
  if (!options.pair_list.empty()) {
    add_listed_pairs(root, options, list);
    return list;
  }
  std::vector<std::string> left_out;
  for (const fs::path& folder : folders_in(root / "sequences")) {
    const std::string name = folder.filename().string();
    if (!wanted(options, name)) continue;
    if (options.sequences.empty() && name.size() == 2 && name > kLastWithPoses) {
      left_out.push_back(name);
      continue;
    }
    list.groups.push_back(drawn_pairs(read_sequence(root, folder), options, list));
  }
  if (!left_out.empty()) {
    list.notes.push_back(fmt::format("{} sequence{} after {} left out: their poses are not published", left_out.size(),
                                     left_out.size() == 1 ? "" : "s", kLastWithPoses));
  }
  if (list.groups.empty() && options.sequences.empty()) {
    throw std::runtime_error(fmt::format("{}: holds no sequence with poses", (root / "sequences").string()));
  }
  return list;
}

}  // namespace consimd::studies::detail
