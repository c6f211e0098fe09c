// Dividing a study among machines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// One of `count` parts of a study. What there is to do is numbered, and dealt out in turns like cards.
struct Shard {
  std::uint32_t index = 1;  ///< from 1 to count
  std::uint32_t count = 1;

  [[nodiscard]] bool owns(std::size_t item) const noexcept { return item % count == index - 1; }

  bool operator==(const Shard&) const = default;
};

/// "2/4"
[[nodiscard]] std::string to_string(const Shard& shard);

/// Inverse of `to_string`. Throws std::invalid_argument that says what is expected.
[[nodiscard]] Shard parse_shard(std::string_view text);

/// The folder of a shard within that of the study, "shard-2-of-4".
[[nodiscard]] std::string folder_name(const Shard& shard);

/// Who starts several copies of a program and numbers them in the environment.
struct Launcher {
  std::string_view name;   ///< as `shard_from_environment` takes it
  std::string_view rank;   ///< variable with the number of a copy
  std::string_view count;  ///< variable with the number of copies
};

/// slurm-array, openmpi, pmi and slurm.
[[nodiscard]] std::span<const Launcher> launchers() noexcept;

/// The value of a variable, or null.
using Environment = std::function<const char*(const char*)>;

/// The shard of this copy of the program, by the launcher of that name, or by the only one that there is: "auto".
///
/// A Slurm array's indices may start anywhere and be evenly spaced. With "auto" the ranks of an MPI launcher count
/// before those of a Slurm step, which may have started that launcher, and launchers of several copies before those of
/// one. Throws std::invalid_argument where a launcher's variables are missing or make no sense, and where several
/// launchers divide the work differently.
[[nodiscard]] Shard shard_from_environment(std::string_view launcher, const Environment& environment);

}  // namespace studies
}  // namespace consimd
