// Problems without a pose, by what their matches keep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::bench {

struct NoPose {
  Correspondences correspondences;
  double noise_bound = 0.0;
};

struct ProblemKind {
  std::string name;
  std::function<NoPose(std::size_t rows, std::uint64_t trial)> make;  ///< a function of its arguments alone
};

/// Those of the synthetic generator, none of whose rows are inliers. `seed`: of the generator.
[[nodiscard]] std::vector<ProblemKind> synthetic_kinds(std::uint64_t seed);

/// Folders of the recorded pairs, CASE/{correspondences.txt,pose.txt,case.json}, below `correspondences` and
/// `hard_pairs` of a folder, in the order of their names.
[[nodiscard]] std::vector<std::filesystem::path> case_folders(const std::filesystem::path& data);

/// Rows that the true pose of a recorded pair does not explain, drawn at random, with their targets exchanged: among
/// all of them, and among each 32 whose sources lie together; and sources and targets of two pairs. `folders`: of
/// cases, at least two for the last. Throws std::runtime_error where a file does not hold what it should.
[[nodiscard]] std::vector<ProblemKind> recorded_kinds(const std::vector<std::filesystem::path>& folders,
                                                      std::uint64_t seed);

}  // namespace consimd::bench
