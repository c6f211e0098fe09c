// What a self-contained page is put together with.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "files/json_text.hpp"

namespace consimd::studies {

/// Text that shows as itself in an element or a quoted attribute of HTML and SVG. Control characters, which XML cannot
/// hold, and bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string escaped(std::string_view text);

/// JSON that an element of a page can hold: nothing in it ends the element.
[[nodiscard]] std::string page_json(const Json& json);

[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

/// The numbers as little-endian IEEE singles, in Base64.
[[nodiscard]] std::string base64_floats(std::span<const float> numbers);

/// `page` with each {{name}} replaced by the value of that name. Throws std::logic_error at a name without a value.
[[nodiscard]] std::string filled(std::string_view page,
                                 std::span<const std::pair<std::string_view, std::string_view>> values);

/// Whole numbers with thin spaces between thousands.
[[nodiscard]] std::string grouped(std::size_t number);

}  // namespace consimd::studies
