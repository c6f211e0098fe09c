#include "named_columns.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

namespace consimd::synth {
namespace {

constexpr std::string_view kAxes = "xyz";
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_mark(char c) { return std::string_view("_. -:/").find(c) != std::string_view::npos; }
bool is_small(char c) { return c >= 'a' && c <= 'z'; }
bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }

/// In small letters, without a unit, in brackets or behind "in". A capital axis beside small letters gets a mark, as in
/// targetX.
std::string plain(std::string_view name) {
  const std::string_view bare = name.substr(0, std::min(name.find_first_of("[("), name.find(" in ")));
  std::string text;
  for (std::size_t k = 0; k < bare.size(); ++k) {
    const bool is_first = k == 1 && bare.size() > 2 && is_small(bare[1]) && bare[0] >= 'X' && bare[0] <= 'Z';
    const bool is_last = k > 0 && k + 1 == bare.size() && is_capital(bare[k]) && is_small(bare[k - 1]);
    if (is_first || is_last) text += '_';
    text += is_capital(bare[k]) ? static_cast<char>(bare[k] - 'A' + 'a') : bare[k];
  }
  while (!text.empty() && is_mark(text.back())) text.pop_back();
  return text;
}

/// Whether a name says that it is of the source or the target.
bool names_a_side(const std::string& name) {
  return std::ranges::any_of(std::array{"source", "src", "target", "tgt"},
                             [&](const char* side) { return name.find(side) != std::string::npos; });
}

struct NamedAxis {
  std::size_t axis;   ///< 0 to 2
  std::string cloud;  ///< what the name has beside it, without marks
};

/// The axis is at the beginning or the end of a name: alone, beside digits or a mark, or beside one letter, which is
/// the cloud's. None of a normal, nx or normal_x.
std::optional<NamedAxis> named_axis(const std::string& name) {
  const auto without_marks = [](std::string text) {
    std::erase_if(text, is_mark);
    return text;
  };
  const auto letters =
      static_cast<std::size_t>(std::ranges::count_if(name, [](char c) { return !is_digit(c) && !is_mark(c); }));
  const auto read = [&](char axis, char beside, std::string others) -> std::optional<NamedAxis> {
    const std::size_t found = kAxes.find(axis);
    if (found == std::string_view::npos || (letters > 2 && !is_mark(beside))) return std::nullopt;
    others = without_marks(std::move(others));
    if (others == "n" || others.starts_with("normal")) return std::nullopt;
    return NamedAxis{found, std::move(others)};
  };
  if (name.empty()) return std::nullopt;
  if (name.size() == 1) return read(name.front(), '_', "");
  // The axis may stand before digits, as in x1 and source_x1.
  const std::size_t end = name.find_last_not_of("0123456789_");
  if (end != std::string::npos && end > 0) {
    if (auto last = read(name[end], name[end - 1], name.substr(0, end) + name.substr(end + 1))) return last;
  }
  return read(name.front(), is_digit(name[1]) ? '_' : name[1], name.substr(1));
}

/// 0: a source's, 1: a target's; kNone: neither.
std::size_t side_of(const std::string& cloud) {
  constexpr std::string_view kSides[][3] = {{"source", "src", "moving"}, {"target", "tgt", "dst"}};
  constexpr std::string_view kShort[][3] = {{"s", "from", "p"}, {"t", "to", "q"}};
  for (const std::size_t side : {0U, 1U}) {
    for (const std::string_view word : kSides[side]) {
      if (cloud.starts_with(word)) return side;
    }
    for (const std::string_view word : kShort[side]) {
      if (cloud == word) return side;
    }
  }
  return cloud.starts_with("ref") || cloud.starts_with("dest") || cloud.starts_with("fixed") ? 1 : kNone;
}

/// The columns of a cloud by axis; kNone where there is none.
struct Cloud {
  std::string name;
  std::array<std::size_t, 3> columns{kNone, kNone, kNone};

  [[nodiscard]] bool is_whole() const {
    return std::ranges::none_of(columns, [](std::size_t column) { return column == kNone; });
  }
};

/// Whether the second of two clouds is the source.
bool are_exchanged(const Cloud& first, const Cloud& second) {
  const std::size_t a = side_of(first.name), b = side_of(second.name);
  if (a != b && (a != kNone || b != kNone)) return a == 1 || b == 0;
  const auto stem = [](const std::string& name) {
    return std::string_view(name).substr(0, name.find_last_not_of("0123456789") + 1);
  };
  if (stem(first.name) != stem(second.name)) return false;
  return std::pair(second.name.size(), second.name) < std::pair(first.name.size(), first.name);
}

}  // namespace

NamedColumns columns_by_name(const std::vector<std::string>& names) {
  std::vector<Cloud> clouds;
  std::vector<std::size_t> axes;  // of those columns that have one, in order
  for (std::size_t column = 0; column < names.size(); ++column) {
    const std::optional<NamedAxis> named = named_axis(plain(names[column]));
    if (!named) continue;
    axes.push_back(named->axis);
    // It belongs to the cloud of that name that lacks this axis; where none does, another of that name begins.
    const auto lacks = [&](const Cloud& cloud) {
      return cloud.name == named->cloud && cloud.columns[named->axis] == kNone;
    };
    auto cloud = std::ranges::find_if(clouds, lacks);
    if (cloud == clouds.end()) cloud = clouds.insert(clouds.end(), {named->cloud});
    cloud->columns[named->axis] = column;
  }
  NamedColumns result{.kind = NamedColumns::Kind::unclear};
  if (axes.empty()) {
    if (std::ranges::none_of(names, [](const std::string& name) { return names_a_side(plain(name)); })) return {};
    return result;
  }
  if (clouds.size() != 2 || !std::ranges::all_of(clouds, &Cloud::is_whole)) return result;
  // Of two clouds without names of their own only the order tells.
  constexpr std::array<std::size_t, 6> kInOrder{0, 1, 2, 0, 1, 2};
  if (clouds[0].name == clouds[1].name && !std::ranges::equal(axes, kInOrder)) return result;
  if (are_exchanged(clouds[0], clouds[1])) std::swap(clouds[0], clouds[1]);
  result.kind = NamedColumns::Kind::found;
  std::ranges::copy(clouds[0].columns, result.columns.begin());
  std::ranges::copy(clouds[1].columns, result.columns.begin() + 3);
  return result;
}

}  // namespace consimd::synth
