#include <consimd/studies/shard.hpp>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "text/words.hpp"

namespace consimd::studies {
namespace {

constexpr std::uint32_t kMostShards = 1'000'000;
constexpr std::string_view kArray = "slurm-array";
constexpr std::string_view kStep = "slurm";

constexpr Launcher kLaunchers[] = {{kArray, "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT"},
                                   {"openmpi", "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                   {"pmi", "PMI_RANK", "PMI_SIZE"},
                                   {kStep, "SLURM_PROCID", "SLURM_NTASKS"}};

class LauncherVariables {
 public:
  explicit LauncherVariables(const Environment& environment) : environment_(environment) {}

  [[nodiscard]] const char* text(std::string_view name) const { return environment_(std::string(name).c_str()); }

  [[nodiscard]] bool has(const Launcher& launcher) const {
    return text(launcher.rank) != nullptr && text(launcher.count) != nullptr;
  }

  /// The missing ones, "A" or "A and B".
  [[nodiscard]] std::string missing(const Launcher& launcher) const {
    std::vector<std::string_view> names;
    for (const std::string_view name : {launcher.rank, launcher.count}) {
      if (text(name) == nullptr) names.push_back(name);
    }
    return fmt::format("{}", fmt::join(names, " and "));
  }

  [[nodiscard]] Shard shard(const Launcher& launcher) const {
    const std::uint32_t count = number(launcher.count);
    std::uint32_t rank = number(launcher.rank);
    if (launcher.name == kArray) rank = array_rank(rank, count);
    if (count < 1 || count > kMostShards || rank >= count) {
      throw std::invalid_argument(fmt::format("{} {} is no rank among {} {}", launcher.rank, text(launcher.rank),
                                              launcher.count, text(launcher.count)));
    }
    return {.index = rank + 1, .count = count};
  }

 private:
  [[nodiscard]] std::uint32_t number(std::string_view name) const {
    const std::optional<std::uint32_t> value = text::number_in<std::uint32_t>(text(name));
    if (!value) throw std::invalid_argument(fmt::format("{}: '{}' is not a whole number", name, text(name)));
    return *value;
  }

  [[nodiscard]] std::uint32_t number(std::string_view name, std::uint32_t otherwise) const {
    return text(name) == nullptr ? otherwise : number(name);
  }

  /// Position of a task's index in its array: Slurm numbers as it is told to.
  [[nodiscard]] std::uint32_t array_rank(std::uint32_t id, std::uint32_t count) const {
    const std::uint32_t first = number("SLURM_ARRAY_TASK_MIN", 0);
    const std::uint32_t step = std::max(1u, number("SLURM_ARRAY_TASK_STEP", 1));
    const std::uint64_t last = first + std::uint64_t{step} * (std::max(1u, count) - 1);
    if (id < first || id > last || (id - first) % step != 0 || number("SLURM_ARRAY_TASK_MAX", id) > last) {
      throw std::invalid_argument(
          fmt::format("SLURM_ARRAY_TASK_ID {} is not one of {} evenly spaced indices from SLURM_ARRAY_TASK_MIN {} in "
                      "steps of {}; give K/N for such an array",
                      id, count, first, step));
    }
    return (id - first) / step;
  }

  const Environment& environment_;
};

struct Found {
  const Launcher* launcher;
  Shard shard;
};

Shard only_one(std::vector<Found> found) {
  const auto is = [](std::string_view name) { return [name](const Found& f) { return f.launcher->name == name; }; };
  const auto is_mpi = [](const Found& f) { return f.launcher->name != kArray && f.launcher->name != kStep; };
  if (std::ranges::any_of(found, is_mpi)) std::erase_if(found, is(kStep));
  const auto of_one = [](const Found& f) { return f.shard.count == 1; };
  if (!std::ranges::all_of(found, of_one)) std::erase_if(found, of_one);
  if (std::ranges::all_of(found, [&](const Found& f) { return f.shard == found.front().shard; })) {
    return found.front().shard;
  }
  std::vector<std::string> parts;
  parts.reserve(found.size());
  for (const auto& [launcher, shard] : found) {
    parts.push_back(fmt::format("{} says {} ({})", launcher->name, to_string(shard), launcher->rank));
  }
  throw std::invalid_argument(
      fmt::format("the environment names several: {}; give one of these names, or K/N", fmt::join(parts, ", ")));
}

}  // namespace

std::string to_string(const Shard& shard) { return fmt::format("{}/{}", shard.index, shard.count); }

Shard parse_shard(std::string_view text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::optional<std::uint32_t> index = text::number_in<std::uint32_t>(text.substr(0, slash));
  const std::optional<std::uint32_t> count =
      text::number_in<std::uint32_t>(text.substr(std::min(slash + 1, text.size())));
  if (!index || !count || *index < 1 || *index > *count || *count > kMostShards) {
    throw std::invalid_argument(fmt::format(
        "expected K/N, the K-th of N parts with K from 1 to N and N up to {}, got '{}'", kMostShards, text));
  }
  return {.index = *index, .count = *count};
}

std::string folder_name(const Shard& shard) { return fmt::format("shard-{}-of-{}", shard.index, shard.count); }

std::span<const Launcher> launchers() noexcept { return kLaunchers; }

Shard shard_from_environment(std::string_view launcher, const Environment& environment) {
  const LauncherVariables variables(environment);
  std::vector<Found> found;
  std::vector<std::string> missing;
  for (const Launcher& candidate : kLaunchers) {
    if (launcher != "auto" && launcher != candidate.name) continue;
    if (variables.has(candidate)) {
      found.push_back({&candidate, variables.shard(candidate)});
    } else {
      missing.push_back(fmt::format("{}: no {}", candidate.name, variables.missing(candidate)));
    }
  }
  if (found.empty() && missing.empty()) {
    std::vector<std::string_view> names;
    for (const Launcher& candidate : kLaunchers) names.push_back(candidate.name);
    throw std::invalid_argument(fmt::format("expected K/N, auto, {}, got '{}'", fmt::join(names, ", "), launcher));
  }
  if (found.empty()) {
    throw std::invalid_argument(fmt::format("the environment names no part ({}); give K/N", fmt::join(missing, ", ")));
  }
  return only_one(std::move(found));
}

}  // namespace consimd::studies
