#include <consimd/studies/figures.hpp>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

/// Runs a command to its end, silent unless `show_errors`. Its exit status; 127 if it could not be started or was
/// killed.
int run(std::vector<std::string> command, bool show_errors) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (!show_errors) posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);

  int status = 0;
  if (failed != 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status)) return 127;
  return WEXITSTATUS(status);
}

std::string interpreter() {
  std::vector<std::string> candidates = {"python3", "/usr/bin/python3"};
  if (const char* chosen = std::getenv("CONSIMD_PYTHON")) candidates = {chosen};
  for (const std::string& candidate : candidates) {
    if (run({candidate, "-I", "-c", "import matplotlib"}, false) == 0) return candidate;
  }
  throw std::runtime_error(
      "no Python with matplotlib found: install python3-matplotlib (Debian, Ubuntu) or set CONSIMD_PYTHON to one");
}

fs::path path_of(const fs::path& script, const fs::path& program) {
  if (const char* chosen = std::getenv("CONSIMD_PLOT_SCRIPT")) return fs::absolute(chosen);
  const fs::path installed = program.parent_path() / "../share/consimd" / script.filename();
  // A program that does not know where it is must not look in the current folder.
  return program.is_absolute() && fs::exists(installed) ? installed : CONSIMD_PLOT_SCRIPTS / script;
}

}  // namespace

void draw_figures(std::string_view script, const fs::path& folder, const fs::path& program) {
  const fs::path path = path_of(script, program);
  if (!fs::exists(path)) throw std::runtime_error(fmt::format("the plotting script {} is missing", path.string()));
  const std::string python = interpreter();
  if (const int status = run({python, "-I", "-B", path.string(), folder.string()}, true); status != 0) {
    throw std::runtime_error(
        fmt::format("'{} {} {}' failed with exit status {}", python, path.string(), folder.string(), status));
  }
}

}  // namespace consimd::studies
