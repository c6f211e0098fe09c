#include <consimd/features/voxel_grid.hpp>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "grid/cell_keys.hpp"

namespace consimd::features {
namespace {

/// Points that one table takes. A constant: the order of the sums, hence their bits, must not depend on the threads.
constexpr std::size_t kBlockSize = 131072;

struct Voxel {
  std::uint64_t key;
  std::array<double, 3> sum;
  std::uint64_t count;
};

/// Voxels by key, in the order of their first points: open addressing, at most half full.
class VoxelTable {
 public:
  explicit VoxelTable(std::size_t expected) { grow(expected); }

  Voxel& at(std::uint64_t key) {
    // Points follow one another along a scan: the next is often in the same voxel.
    if (last_ < voxels_.size() && voxels_[last_].key == key) return voxels_[last_];
    std::size_t slot = place(key);
    for (; slots_[slot] != kEmpty; slot = (slot + 1) & (slots_.size() - 1)) {
      if (voxels_[slots_[slot]].key == key) {
        last_ = slots_[slot];
        return voxels_[last_];
      }
    }
    if (2 * (voxels_.size() + 1) > slots_.size()) {
      grow(2 * voxels_.size());
      return at(key);
    }
    last_ = voxels_.size();
    slots_[slot] = static_cast<std::uint32_t>(last_);
    return voxels_.emplace_back(Voxel{key, {}, 0});
  }

  [[nodiscard]] const std::vector<Voxel>& voxels() const noexcept { return voxels_; }

 private:
  static constexpr std::uint32_t kEmpty = 0xffffffff;

  [[nodiscard]] std::size_t place(std::uint64_t key) const noexcept {
    return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15u) >> 20) & (slots_.size() - 1);
  }

  void grow(std::size_t expected) {
    std::size_t size = 1024;
    while (size < 2 * (expected + 1)) size *= 2;
    slots_.assign(size, kEmpty);
    for (std::size_t v = 0; v < voxels_.size(); ++v) {
      std::size_t slot = place(voxels_[v].key);
      while (slots_[slot] != kEmpty) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = static_cast<std::uint32_t>(v);
    }
  }

  std::vector<std::uint32_t> slots_;
  std::vector<Voxel> voxels_;
  std::size_t last_ = 0;
};

/// The voxels of points begin to end - 1.
std::vector<Voxel> voxels_of(const Cloud& cloud, const detail::CellKeys& keys, std::size_t begin, std::size_t end) {
  const CloudView view = cloud.view();
  VoxelTable table((end - begin) / 8);
  for (std::size_t i = begin; i < end; ++i) {
    Voxel& voxel = table.at(keys(i));
    for (std::size_t c = 0; c < 3; ++c) voxel.sum[c] += static_cast<double>(view.points(c)[i]);
    ++voxel.count;
  }
  return table.voxels();
}

std::vector<Voxel> occupied(const Cloud& cloud, double side) {
  const detail::CellKeys keys(cloud, side, "voxel");
  const std::size_t blocks = (cloud.size() + kBlockSize - 1) / kBlockSize;
  if (blocks <= 1) return voxels_of(cloud, keys, 0, cloud.size());
  std::vector<std::vector<Voxel>> parts(blocks);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    parts[b] = voxels_of(cloud, keys, b * kBlockSize, std::min(cloud.size(), (b + 1) * kBlockSize));
  });
  VoxelTable whole(parts.front().size());
  for (std::vector<Voxel>& part : parts) {
    for (const Voxel& from : part) {
      Voxel& voxel = whole.at(from.key);
      for (std::size_t c = 0; c < 3; ++c) voxel.sum[c] += from.sum[c];
      voxel.count += from.count;
    }
    part = {};
  }
  return whole.voxels();
}

}  // namespace

Cloud voxel_grid(const Cloud& cloud, double voxel) {
  const std::vector<Voxel> voxels = occupied(cloud, voxel);
  std::vector<std::uint64_t> keys(voxels.size());
  std::transform(voxels.begin(), voxels.end(), keys.begin(), [](const Voxel& v) { return v.key; });
  const std::vector<std::uint32_t> order = detail::sorting_order(keys);
  std::array<std::vector<float>, 3> means;
  for (std::size_t c = 0; c < 3; ++c) {
    means[c].resize(voxels.size());
    std::transform(order.begin(), order.end(), means[c].begin(), [&](std::uint32_t v) {
      return static_cast<float>(voxels[v].sum[c] / static_cast<double>(voxels[v].count));
    });
  }
  return Cloud::in_frame_of(cloud, {means[0].data(), means[1].data(), means[2].data()}, voxels.size());
}

std::size_t occupied_voxels(const Cloud& cloud, double voxel) { return occupied(cloud, voxel).size(); }

}  // namespace consimd::features
