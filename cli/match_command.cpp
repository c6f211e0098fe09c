#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

#include <consimd/studies/replace_file.hpp>
#include "cloud_arguments.hpp"
#include "commands.hpp"
#include "option_checks.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

struct Options {
  std::string source;
  std::string target;
  CloudArguments clouds;
  std::uint64_t seed = 1;
  int threads = 1;
  std::string out = "consimd-matches";
};

int run_match(const Options& options) {
  const std::filesystem::path file = std::filesystem::path(options.out) / "correspondences.txt";
  const features::CloudMatchingOptions matching = matching_options(options.clouds, options.seed);
  const CloudPair clouds = read_clouds(options.source, options.target, options.clouds);
  studies::require_writable_folder(options.out);
  const features::CloudMatches matches =
      with_threads(options.threads, [&] { return features::match_clouds(clouds.source, clouds.target, matching); });
  studies::replace_file(file, correspondence_text(matches));
  fmt::print("{}{} correspondences in {}\n", to_text(matches, options.clouds), matches.matches.size(), file.string());
  return kSuccess;
}

}  // namespace

void add_match_command(CLI::App& app, Action& run) {
  CLI::App* command = app.add_subcommand("match", "Find correspondences between two clouds, for any solver");
  auto options = std::make_shared<Options>();
  command->add_option("SOURCE", options->source, fmt::format("Cloud: {}. '-' is the standard input", kCloudForms))
      ->required();
  command->add_option("TARGET", options->target, "Cloud to match it with")->required();
  add_columns_option(
      *command, options->clouds,
      "Of text with other columns: which are x y z of both clouds, counted from 1, as in 2,3,4; or six, "
      "three of each. Not needed where a first line or a comment names them, or rows are numbered before "
      "them");
  add_cloud_options(*command, options->clouds);
  command->add_option("--seed", options->seed, "Seed of the draw of points")
      ->check(whole_number())
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  command->add_option("--out", options->out, "Folder that gets correspondences.txt")->capture_default_str();
  command->footer(
      "Exit code: 0, or 2 on bad usage or input.\n"
      "Example:\n"
      "  consimd match a.pcd b.pcd --voxel 0.3 --out pair\n"
      "  consimd register pair/correspondences.txt --noise-bound 0.6");
  command->callback([&run, options] { run = [options] { return run_match(*options); }; });
}

}  // namespace consimd::cli
