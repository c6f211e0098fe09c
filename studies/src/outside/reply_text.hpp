// The line that an outside program answers.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <consimd/poses/rigid_fit.hpp>

namespace consimd::studies {

struct ReplyText {
  std::optional<RigidTransform> pose;  ///< finite numbers, not yet known to be a rotation
  std::optional<double> seconds;
};

/// Reads "none" or the rows of a 3 x 4 or 4 x 4 matrix, then "time SECONDS" if the program tells it; words are
/// separated by blanks, tabs or commas. Throws std::invalid_argument that says what is wrong.
[[nodiscard]] ReplyText parse_reply(std::string_view line);

/// A foreign text with '?' in place of what is no printable ASCII.
[[nodiscard]] std::string printable(std::string_view text);

/// The beginning of a foreign text, in quotes and on one line.
[[nodiscard]] std::string shown_text(std::string_view text);

}  // namespace consimd::studies
