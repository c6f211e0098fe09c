// Lists of values as people type them.
#pragma once

#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// "start:end:count" gives `count` >= 2 evenly spaced values, both ends included; "v1,v2,..." is taken as is.
/// Spaced values are rounded to 12 significant digits: 0.1:5:50 holds 0.3, not 0.30000000000000004.
/// Throws std::invalid_argument that quotes the text and says what was expected.
[[nodiscard]] std::vector<double> parse_value_list(std::string_view text);

/// One finite number and nothing else, whatever the locale. Throws std::invalid_argument.
[[nodiscard]] double parse_number(std::string_view text);

}  // namespace studies
}  // namespace consimd
