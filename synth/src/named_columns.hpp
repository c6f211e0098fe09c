// Which columns of a table are a correspondence, by their names.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace consimd::synth {

/// What names tell of the columns of source x y z and target x y z.
struct NamedColumns {
  enum class Kind {
    none,     ///< nothing: they name no axes
    found,    ///< the columns
    unclear,  ///< they name axes, but not one x y z of either cloud
  };
  Kind kind = Kind::none;
  std::array<std::size_t, 6> columns{};  ///< from 0, where found
};

/// Columns belong to a cloud by what their names have beside the axis: x1, source_y, sz, "tx [m]", z_dst. Which of two
/// clouds is the source is told by words (source, src, s, from; target, tgt, t, ref, dst, to) or numbers (the smaller
/// one), and else by the order of the columns. Of six columns x y z x y z the first three are the source.
NamedColumns columns_by_name(const std::vector<std::string>& names);

}  // namespace consimd::synth
