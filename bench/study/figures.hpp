// Drawing figures with the Python scripts beside their data's sources.
#pragma once

#include <filesystem>
#include <string_view>

namespace consimd::study {

/// Scripts, as they lie in bench/.
inline constexpr std::string_view kSweepScript = "study/plot_sweep.py";
inline constexpr std::string_view kIterationsScript = "compare/plot_iterations.py";

/// Draws what `script` makes of the data in `folder`, as SVG and PNG. $CONSIMD_PLOT_SCRIPT is another script; else it
/// is the one of the same name in `../share/consimd` seen from `program`'s folder, else that in the source tree. The
/// interpreter is the first of $CONSIMD_PYTHON, python3 and /usr/bin/python3 that has matplotlib. Throws
/// std::runtime_error that says in one line what is missing.
void draw_figures(std::string_view script, const std::filesystem::path& folder, const std::filesystem::path& program);

}  // namespace consimd::study
