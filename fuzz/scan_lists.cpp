// What lies beside the scans of a data set. The input is, each up to a byte 0: calib.txt, poses and list of pairs of
// KITTI; gt.log, gt.info and gt_overlap.log of 3DMatch; the pairs.csv of anybody.
#include <consimd/studies/scan_layout.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "holds.hpp"
#include "process_folder.hpp"

namespace {

namespace fs = std::filesystem;
using namespace consimd;

/// A folder for the life of the process, with scans that nobody reads.
fs::path make_folder() {
  const fs::path folder = fuzz::make_process_folder();
  for (const char* sub : {"sequences/00/velodyne", "poses", "scene"}) fs::create_directories(folder / sub);
  for (const char* scan : {"sequences/00/velodyne/000000.bin", "sequences/00/velodyne/000001.bin",
                           "scene/cloud_bin_0.ply", "scene/cloud_bin_1.ply", "scene/cloud_bin_2.ply"}) {
    std::ofstream(folder / scan) << "x";
  }
  return folder;
}

void read(const studies::LayoutOptions& options) {
  fuzz::may_refuse([&] {
    for (const studies::ScanGroup& group : studies::read_scan_list(options, true).groups) {
      for (const studies::ScanPair& pair : group.pairs) {
        fuzz::require(pair.T_target_source.matrix().allFinite(), "a finite pose");
        fuzz::require(pair.T_target_source.linear().determinant() > 0.99, "a rotation");
        if (pair.limits) fuzz::require(pair.limits->rotation_deg > 0.0 && pair.limits->translation > 0.0, "limits");
        if (pair.information) fuzz::require((*pair.information)[0] > 0.0, "points in the overlap");
      }
    }
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fs::path folder = make_folder();
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  for (const char* name : {"sequences/00/calib.txt", "poses/00.txt", "list.txt", "scene/gt.log", "scene/gt.info",
                           "scene/gt_overlap.log", "pairs.csv"}) {
    const std::string_view text = rest.substr(0, rest.find('\0'));
    rest.remove_prefix(std::min(rest.size(), text.size() + 1));
    std::ofstream(folder / name, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
  }
  const std::string path = folder.string();
  read({.folder = path, .layout = "kitti", .distance = 1.0});
  read({.folder = path, .layout = "kitti", .pair_list = path + "/list.txt"});
  read({.folder = path, .layout = "3dmatch", .overlap = std::array<double, 2>{0.1, 0.9}, .skip_consecutive = true});
  read({.folder = path, .layout = "3dmatch"});
  read({.folder = path, .layout = "pairs"});
  return 0;
}
