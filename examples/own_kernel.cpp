// A kernel of one's own on consimd's correspondences: checked against its plain loop, and timed on the workloads and in
// the table of consimd's kernels, one of which stands beside it.
//   own_kernel [SIZE...]      correspondences; 3000 if none are given
#include <charconv>
#include <cstdint>
#include <cstring>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/isa.hpp>
#include <consimd/kernels/length_consistency.hpp>
#include <consimd/studies/kernel_timing.hpp>

namespace studies = consimd::studies;

namespace {

using consimd::CorrespondenceView;
using studies::KernelOutput;
using studies::KernelWorkload;

// Displacement consistency, for clouds without a rotation between them: j agrees with the seed k when
// |(q_j - q_k) - (p_j - p_k)| < bound. For every seed the number of j that agree.

/// The bound in the working frame of the arrays.
float working_bound(const KernelWorkload& workload) {
  return static_cast<float>(workload.consistency_bound * workload.correspondences.scale());
}

/// The specification: one correspondence at a time. NaN, as in the padding, agrees with nothing.
void plain(const KernelWorkload& workload, KernelOutput& counts) {
  const CorrespondenceView view = workload.correspondences;
  const float bound = working_bound(workload);
  counts.assign(workload.batch(), 0);
  for (std::size_t s = 0; s < workload.batch(); ++s) {
    const std::uint32_t k = workload.seeds[s];
    for (std::size_t j = 0; j < view.size(); ++j) {
      float squared = 0.0F;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* const p = view.source(axis);
        const float* const q = view.target(axis);
        const float difference = (q[j] - q[k]) - (p[j] - p[k]);
        squared = axis == 0 ? difference * difference : squared + difference * difference;
      }
      if (squared < bound * bound) ++counts[s];
    }
  }
}

// The same for eight correspondences at once, by the vectors that g++ and clang know on every processor. The arrays are
// padded with NaN to a multiple of 64, so there is no rest to care for, and 64-byte aligned.
using Floats = float __attribute__((vector_size(32)));
using Integers = std::int32_t __attribute__((vector_size(32)));
constexpr std::size_t kLanes = sizeof(Floats) / sizeof(float);

// GNU vectors are passed by reference: how they are passed by value depends on the instruction set.
void load(const float* from, Floats& to) { std::memcpy(&to, from, sizeof to); }

void vectors(const KernelWorkload& workload, KernelOutput& counts) {
  const CorrespondenceView view = workload.correspondences;
  const float bound = working_bound(workload);
  counts.assign(workload.batch(), 0);
  for (std::size_t s = 0; s < workload.batch(); ++s) {
    const std::uint32_t k = workload.seeds[s];
    Integers passed{};
    for (std::size_t j = 0; j < view.padded_size(); j += kLanes) {
      Floats squared{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Floats p, q;
        load(view.source(axis) + j, p);
        load(view.target(axis) + j, q);
        const Floats difference = (q - view.target(axis)[k]) - (p - view.source(axis)[k]);
        squared = axis == 0 ? difference * difference : squared + difference * difference;
      }
      passed -= squared < bound * bound;  // a lane that holds is -1
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) counts[s] += static_cast<std::uint32_t>(passed[lane]);
  }
}

double pairs(const KernelWorkload& workload) {
  return static_cast<double>(workload.batch()) * static_cast<double>(workload.size());
}

/// One of consimd's, on an instruction set.
studies::KernelCall length_consistency_on(consimd::Isa isa) {
  return [isa](const KernelWorkload& workload, KernelOutput& counts) {
    consimd::set_active_isa(isa);
    counts.resize(workload.batch());
    consimd::length_consistency_counts(workload.correspondences, workload.seeds, workload.consistency_bound, counts);
  };
}

std::vector<std::size_t> sizes_of(int argc, char** argv) {
  std::vector<std::size_t> sizes;
  for (int i = 1; i < argc; ++i) {
    const std::string_view text = argv[i];
    std::size_t size = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), size);
    if (error != std::errc() || rest != text.data() + text.size()) {
      throw std::invalid_argument("expected numbers of correspondences, got '" + std::string(text) + "'");
    }
    sizes.push_back(size);
  }
  if (sizes.empty()) sizes.push_back(3000);
  return sizes;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string widest(consimd::to_string(consimd::active_isa()));
  const std::vector<studies::TimedKernel> kernels{
      {.name = "displacement_consistency_counts",
       .item = "pairs",
       .items = pairs,
       .reference = plain,
       .variants = {{"vectors", vectors}}},
      {.name = "length_consistency_counts",
       .item = "pairs",
       .items = pairs,
       .reference = length_consistency_on(consimd::Isa::scalar),
       .variants = {{widest == "scalar" ? "active" : widest, length_consistency_on(consimd::active_isa())}}},
  };
  const std::vector<std::size_t> sizes = sizes_of(argc, argv);
  // Throws where a variant does not give the reference's words.
  const std::vector<studies::KernelRate> rates = studies::time_kernels(kernels, {.sizes = sizes});
  for (const std::size_t size : sizes) std::cout << to_markdown(studies::kernel_rate_table(rates, size)) << "\n";
  return 0;
} catch (const std::exception& error) {
  std::cerr << "own_kernel: " << error.what() << "\n";
  return 1;
}
