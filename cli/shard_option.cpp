#include "shard_option.hpp"

#include <cstdlib>
#include <stdexcept>

#include <fmt/format.h>

namespace consimd::cli {

void add_shard_option(CLI::App& command, std::optional<std::string>& shard) {
  command.add_option("--shard", shard,
                     "Run the K-th of N parts only, in a folder of its own within --out: K/N, or where the part stands "
                     "in the environment: auto, slurm-array, openmpi, pmi or slurm");
}

std::optional<studies::Shard> shard_of(const std::optional<std::string>& text) {
  if (!text) return std::nullopt;
  try {
    if (text->find('/') != std::string::npos) return studies::parse_shard(*text);
    return studies::shard_from_environment(*text, [](const char* name) { return std::getenv(name); });
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("--shard: {}", error.what()));
  }
}

}  // namespace consimd::cli
