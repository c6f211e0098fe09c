#include <consimd/solvers/solver_option.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "text/words.hpp"

namespace consimd {
namespace {

constexpr std::string_view kNone = "none";
constexpr std::string_view kTrue = "true";
constexpr std::string_view kFalse = "false";

template <typename Number>
std::string shortest(Number value) {
  std::array<char, 32> digits{};
  const std::to_chars_result end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  return {digits.data(), end.ptr};
}

[[noreturn]] void reject(const SolverOption& option, const std::string& value) {
  throw std::invalid_argument(option.name + " is " + value + ", expected " + expectation(option));
}

std::string quoted(std::string_view text) { return std::string("'").append(text).append("'"); }

std::string in_words(const TruthRange& /*range*/) { return "true or false"; }

std::string in_words(const WholeRange& range) {
  return "a whole number from " + shortest(range.least) + " to " + shortest(range.most);
}

std::string in_words(const RealRange& range) {
  const bool bounded_below = std::isfinite(range.least), bounded_above = std::isfinite(range.most);
  std::string text = bounded_above || range.most_included ? "a number" : "a finite number";
  if (bounded_below) text += (range.least_included ? " from " : " above ") + shortest(range.least);
  if (bounded_above) {
    text += bounded_below ? " and" : "";
    text += (range.most_included ? " up to " : " below ") + shortest(range.most);
  } else if (range.most_included) {
    text += ", or inf";
  }
  return text;
}

std::string in_words(const NameRange& range) {
  std::string text = "one of: ";
  for (const std::string& name : range.names) text.append(&name == &range.names.front() ? "" : ", ").append(name);
  return text;
}

bool is_in(const TruthRange& /*range*/, const OptionValue& value) { return std::holds_alternative<bool>(value); }

bool is_in(const WholeRange& range, const OptionValue& value) {
  const auto* number = std::get_if<std::uint64_t>(&value);
  return number != nullptr && *number >= range.least && *number <= range.most;
}

bool is_in(const RealRange& range, const OptionValue& value) {
  const auto* number = std::get_if<double>(&value);
  return number != nullptr && (*number > range.least || (range.least_included && *number == range.least)) &&
         (*number < range.most || (range.most_included && *number == range.most));
}

bool is_in(const NameRange& range, const OptionValue& value) {
  const auto* name = std::get_if<std::string>(&value);
  return name != nullptr && std::ranges::find(range.names, *name) != range.names.end();
}

/// The value that a text means to a range; nothing if it means none.
std::optional<OptionValue> value_from(const TruthRange& /*range*/, std::string_view text) {
  if (text == kTrue || text == kFalse) return text == kTrue;
  return std::nullopt;
}

std::optional<OptionValue> value_from(const WholeRange& /*range*/, std::string_view text) {
  return text::number_in<std::uint64_t>(text);
}

std::optional<OptionValue> value_from(const RealRange& /*range*/, std::string_view text) {
  return text::number_in<double>(text);
}

std::optional<OptionValue> value_from(const NameRange& /*range*/, std::string_view text) { return std::string(text); }

struct Text {
  std::string operator()(std::monostate /*none*/) const { return std::string(kNone); }
  std::string operator()(bool value) const { return std::string(value ? kTrue : kFalse); }
  std::string operator()(std::uint64_t value) const { return shortest(value); }
  std::string operator()(double value) const { return shortest(value); }
  std::string operator()(const std::string& value) const { return value; }
};

}  // namespace

std::string to_string(const OptionValue& value) { return std::visit(Text(), value); }

std::string expectation(const SolverOption& option) {
  const std::string text = std::visit([](const auto& range) { return in_words(range); }, option.range);
  return option.may_be_none ? text + ", or none" : text;
}

void require_allowed(const SolverOption& option, const OptionValue& value) {
  if (option.may_be_none && std::holds_alternative<std::monostate>(value)) return;
  if (std::visit([&](const auto& range) { return is_in(range, value); }, option.range)) return;
  reject(option, std::holds_alternative<std::string>(value) ? quoted(to_string(value)) : to_string(value));
}

OptionValue parse_option(const SolverOption& option, std::string_view text) {
  if (option.may_be_none && text == kNone) return std::monostate();
  const std::optional<OptionValue> value =
      std::visit([&](const auto& range) { return value_from(range, text); }, option.range);
  if (!value) reject(option, quoted(text));
  require_allowed(option, *value);
  return *value;
}

const SolverOption& option_named(const std::vector<SolverOption>& options, std::string_view name,
                                 std::string_view owner) {
  const auto found = std::ranges::find(options, name, &SolverOption::name);
  if (found != options.end()) return *found;
  std::string message = std::string(owner) + " has no option " + quoted(name);
  if (!options.empty()) message += ", expected one of: ";
  for (const SolverOption& option : options) {
    message.append(&option == &options.front() ? "" : ", ").append(option.name);
  }
  throw std::invalid_argument(message);
}

}  // namespace consimd
