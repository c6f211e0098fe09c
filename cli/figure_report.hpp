// How the figures of a command's output folder are drawn and named.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace consimd::cli {

/// Draws the figures `names` of `folder` with `script` (see studies::draw_figures) and says where they are. Figures
/// that cannot be drawn are told on the standard error, no error: the data are there.
void draw_and_name_figures(std::string_view script, std::string_view folder,
                           const std::vector<std::string_view>& names);

/// The PNG of a drawing that `studies::registration_svg` made. Throws std::runtime_error that says in one line what is
/// missing.
[[nodiscard]] std::string drawn_as_png(std::string_view drawing);

}  // namespace consimd::cli
