#include <consimd/studies/kernel_workload.hpp>

#include <new>
#include <random>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <consimd/synth/noise_study.hpp>

namespace consimd::studies {
namespace {

constexpr std::align_val_t kAlignment{64};

}  // namespace

void KernelWorkload::AlignedDelete::operator()(float* weights) const noexcept {
  ::operator delete[](weights, kAlignment);
}

KernelWorkload::KernelWorkload(std::size_t size, std::size_t batch) {
  if (size < 3) throw std::invalid_argument(fmt::format("size: expected 3 correspondences or more, got {}", size));
  if (batch < 1) throw std::invalid_argument("batch: expected a hypothesis or more, got 0");
  problem = synth::noise_study_problem({.correspondences = size, .outlier_ratio = 0.9, .sigma = noise_bound / 3.0});
  correspondences = problem.correspondences();

  std::mt19937_64 bits(1);  // NOLINT(bugprone-random-generator-seed): always the same workload
  const auto unit = [&bits] { return static_cast<double>(bits() >> 11U) * 0x1p-52 - 1.0; };  // [-1, 1)
  const auto row = [&bits, size] { return static_cast<std::uint32_t>(bits() % size); };
  const auto vector = [&unit] {
    const double x = unit(), y = unit(), z = unit();
    return Eigen::Vector3d(x, y, z);
  };
  for (std::size_t h = 0; h < batch; ++h) {
    seeds.push_back(row());
    const std::uint32_t first = row();
    pairs.push_back({first, row()});
    // A small turn without the C library's sines.
    const double half_angle = 0.025 * unit();
    const Eigen::Vector3d axis = half_angle * vector().normalized();
    const Eigen::Quaterniond turn = Eigen::Quaterniond(1.0, axis.x(), axis.y(), axis.z()).normalized();
    transforms.emplace_back(Eigen::Translation3d(2.0 * vector()) * problem.T_target_source * turn);
    poses.push_back(to_working_pose(to_working_frame(transforms.back(), correspondences)));
  }
  for (std::size_t h = 0; h < size; ++h) {
    const std::uint32_t first = row();
    const std::uint32_t second = row();
    triples.push_back({first, second, row()});
  }

  const CorrespondenceView view = correspondences;
  chosen.resize(view.words());
  weights_.reset(static_cast<float*>(::operator new[](view.padded_size() * sizeof(float), kAlignment)));
  for (std::size_t j = 0; j < view.padded_size(); ++j) {
    weights_[j] = static_cast<float>(0.5 + 0.5 * unit());
    if (j >= size || bits() % 3 != 0) continue;
    chosen[j / 64] |= std::uint64_t{1} << (j % 64);
    rows.push_back(static_cast<std::uint32_t>(j));
  }
}

}  // namespace consimd::studies
