// An option of a solver as a name and a value: what command lines, Python and tables know of it.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// None (of an option that may be left out), a truth value, a whole number, a real number, or a name.
using OptionValue = std::variant<std::monostate, bool, std::uint64_t, double, std::string>;

/// "none", "true", "10000", "0.999", "inf", "inlier_count": the shortest text that `parse_option` takes for the value.
[[nodiscard]] std::string to_string(const OptionValue& value);

/// What an option may be: true or false,
struct TruthRange {};
/// a whole number, both ends included,
struct WholeRange {
  std::uint64_t least = 0;
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
};
/// a real number, never NaN,
struct RealRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool least_included = false;
  bool most_included = false;
};
/// or one of some names.
struct NameRange {
  std::vector<std::string> names;
};
using OptionRange = std::variant<TruthRange, WholeRange, RealRange, NameRange>;

struct SolverOption {
  std::string name;     ///< "max_iterations"
  std::string unit;     ///< "noise bounds", "bytes"; empty where there is none
  std::string meaning;  ///< one line
  OptionRange range;
  bool may_be_none = false;
  OptionValue default_value;
};

/// What the option may be, in words: "a whole number from 0 to 4294967295", "a number above 0 and below 1, or none".
[[nodiscard]] std::string expectation(const SolverOption& option);

/// Throws std::invalid_argument that names the option, the value and what was expected unless the value is of the
/// option's kind and in its range.
void require_allowed(const SolverOption& option, const OptionValue& value);

/// Reads a value. Throws std::invalid_argument as above.
[[nodiscard]] OptionValue parse_option(const SolverOption& option, std::string_view text);

/// The option of that name. `owner`, as "solver 'tcf'", is for the message: throws std::invalid_argument that lists the
/// options there are if there is none of the name.
[[nodiscard]] const SolverOption& option_named(const std::vector<SolverOption>& options, std::string_view name,
                                               std::string_view owner);

}  // namespace consimd
