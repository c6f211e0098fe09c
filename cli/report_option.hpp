// --report: a study as a page to look at.
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

namespace consimd::cli {

void add_report_option(CLI::App& command, std::string& file);

/// Throws unless `file`, if one is given, can be written, before anything is run. It may lie in the folder `out`, which
/// is made for it.
void check_report(const std::string& file, const std::string& out);

/// Writes what `page(command)` makes, if a file is given, and says so. The command is that of this process, as a shell
/// takes it.
void write_report(const std::string& file, const std::function<std::string(std::string_view command)>& page);

}  // namespace consimd::cli
