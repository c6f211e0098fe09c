#include "files/json_text.hpp"

#include <stdexcept>

#include <fmt/format.h>

namespace consimd::studies {
namespace {

constexpr int kDeepest = 32;  // what the library writes has four levels

}  // namespace

Json parse_json(std::string_view text) {
  const Json::parser_callback_t check_depth = [](int depth, Json::parse_event_t /*event*/, Json& /*value*/) {
    if (depth > kDeepest) throw std::invalid_argument(fmt::format("JSON nested deeper than {} levels", kDeepest));
    return true;
  };
  Json json = Json::parse(text, check_depth, false);
  if (json.is_discarded()) throw std::invalid_argument("not JSON");
  return json;
}

}  // namespace consimd::studies
