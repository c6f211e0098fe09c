// --shard of the commands whose work may be divided.
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include <consimd/studies/shard.hpp>

namespace consimd::cli {

void add_shard_option(CLI::App& command, std::optional<std::string>& shard);

/// The shard that the option, or the environment that it names, tells of. Throws std::invalid_argument on a bad one.
[[nodiscard]] std::optional<studies::Shard> shard_of(const std::optional<std::string>& text);

}  // namespace consimd::cli
