// Drawing figures with Python scripts.
#pragma once

#include <filesystem>
#include <string_view>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Scripts.
inline constexpr std::string_view kSweepScript = "plot_sweep.py";
inline constexpr std::string_view kIterationsScript = "plot_iterations.py";
inline constexpr std::string_view kComparisonScript = "plot_comparison.py";
inline constexpr std::string_view kPictureScript = "plot_picture.py";

/// Draws what `script` makes of the data in `folder`, as SVG and PNG. $CONSIMD_PLOT_SCRIPT is another script; else it
/// is the one of the same name in `../share/consimd` seen from `program`'s folder, else that in the source tree. The
/// interpreter is $CONSIMD_PYTHON, else the first of python3 and /usr/bin/python3 that has matplotlib. It runs isolated
/// (-I): nothing is imported from the current folder, $PYTHONPATH or the user's own packages. Throws std::runtime_error
/// that says in one line what is missing.
void draw_figures(std::string_view script, const std::filesystem::path& folder, const std::filesystem::path& program);

}  // namespace studies
}  // namespace consimd
