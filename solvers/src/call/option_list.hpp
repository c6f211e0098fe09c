// The options of a solver, each with its member of the options struct: what the solver checks and the registry tells.
#pragma once

#include <concepts>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <consimd/solvers/solver_option.hpp>

namespace consimd::detail {

template <typename Options>
struct ListedOption {
  SolverOption option;  ///< with the default of Options()
  OptionValue (*get)(const Options&);
  void (*set)(Options&, const OptionValue&);  ///< to a value that the option may have
};

template <typename Options>
using OptionList = std::vector<ListedOption<Options>>;

/// Specialised with an array `kAll` of the pairs name, value of an enumeration that is an option.
template <typename Enum>
struct OptionNames;

// Ranges of real numbers that options have. Infinity leaves out what the option bounds.
inline constexpr RealRange kPositive{.least = 0.0};
inline constexpr RealRange kPositiveOrInfinite{.least = 0.0, .most_included = true};
inline constexpr RealRange kProbability{.least = 0.0, .most = 1.0};
inline constexpr RealRange kShare{.least = 0.0, .most = 1.0, .most_included = true};

template <typename Value>
OptionValue to_option_value(const Value& value) {
  if constexpr (std::is_same_v<Value, bool> || std::floating_point<Value>) {
    return value;
  } else if constexpr (std::unsigned_integral<Value>) {
    return std::uint64_t{value};
  } else if constexpr (std::is_enum_v<Value>) {
    for (const auto& [name, named] : OptionNames<Value>::kAll) {
      if (named == value) return std::string(name);
    }
    return std::string();
  } else {
    return value ? to_option_value(*value) : OptionValue();
  }
}

template <typename Value>
void assign(Value& to, const OptionValue& from) {
  if constexpr (std::is_same_v<Value, bool> || std::floating_point<Value>) {
    to = std::get<Value>(from);
  } else if constexpr (std::unsigned_integral<Value>) {
    to = static_cast<Value>(std::get<std::uint64_t>(from));
  } else if constexpr (std::is_enum_v<Value>) {
    for (const auto& [name, named] : OptionNames<Value>::kAll) {
      if (name == std::get<std::string>(from)) to = named;
    }
  } else if (std::holds_alternative<std::monostate>(from)) {
    to.reset();
  } else {
    to = std::get<typename Value::value_type>(from);
  }
}

template <typename Options, typename Value>
Options class_of(Value Options::*);
template <typename Options, typename Value>
Value value_of(Value Options::*);

template <typename Value>
inline constexpr bool kMayBeNone = false;
template <typename Value>
inline constexpr bool kMayBeNone<std::optional<Value>> = true;

/// An option that is a member of an options struct. range: of real numbers; other types have theirs, whole numbers from
/// `least` on.
template <auto Member>
auto option(std::string_view name, std::string_view unit, std::string_view meaning, const OptionRange& range) {
  using Options = decltype(class_of(Member));
  using Value = decltype(value_of(Member));
  return ListedOption<Options>{
      .option = {.name = std::string(name),
                 .unit = std::string(unit),
                 .meaning = std::string(meaning),
                 .range = range,
                 .may_be_none = kMayBeNone<Value>,
                 .default_value = to_option_value(Options().*Member)},
      .get = [](const Options& options) { return to_option_value(options.*Member); },
      .set = [](Options& options, const OptionValue& value) { assign(options.*Member, value); }};
}

template <auto Member>
auto option(std::string_view name, std::string_view unit, std::string_view meaning, std::uint64_t least = 0) {
  using Value = decltype(value_of(Member));
  if constexpr (std::is_same_v<Value, bool>) {
    return option<Member>(name, unit, meaning, OptionRange(TruthRange()));
  } else if constexpr (std::is_enum_v<Value>) {
    NameRange range;
    for (const auto& named : OptionNames<Value>::kAll) range.names.emplace_back(named.first);
    return option<Member>(name, unit, meaning, OptionRange(range));
  } else {
    static_assert(std::unsigned_integral<Value>, "a real number needs a range");
    return option<Member>(name, unit, meaning, OptionRange(WholeRange{least, std::numeric_limits<Value>::max()}));
  }
}

/// Throws std::invalid_argument on the first option that has a value which it may not have.
template <typename Options>
void require_options(const OptionList<Options>& list, const Options& options) {
  for (const ListedOption<Options>& listed : list) require_allowed(listed.option, listed.get(options));
}

}  // namespace consimd::detail
