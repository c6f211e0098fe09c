#include "report_option.hpp"

#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include <consimd/studies/replace_file.hpp>
#include <consimd/studies/study_page.hpp>

namespace consimd::cli {
namespace {

/// A word as a shell reads it.
std::string shell_word(const std::string& word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./,:=+@%-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// Empty where the system does not tell it.
std::string command_line() {
  std::ifstream words("/proc/self/cmdline", std::ios::binary);
  std::string line, word;
  while (std::getline(words, word, '\0')) line += (line.empty() ? "" : " ") + shell_word(word);
  return line;
}

}  // namespace

void add_report_option(CLI::App& command, std::string& file) {
  command
      .add_option("--report", file,
                  "Write a page to look at the results in a browser, without network: figures that tell their "
                  "numbers, tables to sort and save, the machine and this command. FILE.html")
      ->check([](const std::string& name) { return std::string(name.empty() ? "expected the name of a file" : ""); });
}

void check_report(const std::string& file, const std::string& out) {
  if (!file.empty()) studies::require_writable_page(file, out);
}

void write_report(const std::string& file, const std::function<std::string(std::string_view command)>& page) {
  if (file.empty()) return;
  studies::replace_file(file, page(command_line()));
  fmt::print("report: {}\n", file);
}

}  // namespace consimd::cli
