// Drawing the figures of a study with the Python script beside this file.
#pragma once

#include <filesystem>

namespace consimd::study {

/// Draws recall and errors of the study in `folder`, and maps if it has a limits.csv, as SVG and PNG. The script is
/// $CONSIMD_PLOT_SCRIPT, else `../share/consimd/plot_sweep.py` seen from `program`'s folder, else the one in the source
/// tree; the interpreter the first of $CONSIMD_PYTHON, python3 and /usr/bin/python3 that has matplotlib. Throws
/// std::runtime_error that says in one line what is missing.
void draw_figures(const std::filesystem::path& folder, const std::filesystem::path& program);

}  // namespace consimd::study
