#include "solver_options.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include <nanobind/stl/string.h>

namespace consimd::python {

namespace nb = nanobind;

namespace {

/// A Python object as a value of the kind that a range is of; nothing if it is of another.
std::optional<OptionValue> value_from(const TruthRange& /*range*/, nb::handle object) {
  if (!PyBool_Check(object.ptr())) return std::nullopt;
  return object.is(Py_True);
}

std::optional<OptionValue> value_from(const WholeRange& /*range*/, nb::handle object) {
  std::uint64_t number = 0;
  if (PyBool_Check(object.ptr()) || !nb::try_cast(object, number)) return std::nullopt;
  return number;
}

std::optional<OptionValue> value_from(const RealRange& /*range*/, nb::handle object) {
  double number = 0.0;
  if (PyBool_Check(object.ptr()) || !nb::try_cast(object, number)) return std::nullopt;
  return number;
}

std::optional<OptionValue> value_from(const NameRange& /*range*/, nb::handle object) {
  std::string name;
  if (!nb::try_cast(object, name)) return std::nullopt;
  return name;
}

OptionValue value_from(const SolverOption& option, nb::handle object) {
  if (option.may_be_none && object.is_none()) return std::monostate();
  const std::optional<OptionValue> value =
      std::visit([&](const auto& range) { return value_from(range, object); }, option.range);
  if (value) return *value;
  const std::string message = option.name + " is " + nb::repr(object).c_str() + ", expected " + expectation(option);
  // An integer is of the right type, but negative or larger than any.
  const bool whole = std::holds_alternative<WholeRange>(option.range) && !PyBool_Check(object.ptr());
  if (whole && PyIndex_Check(object.ptr())) throw nb::value_error(message.c_str());
  throw nb::type_error(message.c_str());
}

struct ToObject {
  nb::object operator()(std::monostate /*none*/) const { return nb::none(); }
  template <typename Value>
  nb::object operator()(const Value& value) const {
    return nb::cast(value);
  }
};

const SolverOption* find_option(const Solver& solver, std::string_view name) {
  for (const SolverOption& option : solver.options) {
    if (option.name == name) return &option;
  }
  return nullptr;
}

[[noreturn]] void reject_keyword(const SolverChoice& choice, const std::string& name) {
  std::string message =
      "register() got an unexpected keyword argument '" + name + "'; options of the solver '" + choice.name() + "':";
  for (const SolverOption& option : choice.solver().options) message.append(" ").append(option.name).append(",");
  message.pop_back();
  throw nb::type_error(message.c_str());
}

}  // namespace

SolverChoice solver_with_options(std::string_view solver, const nb::dict& given) {
  SolverChoice choice(solver);
  for (const auto& [key, object] : given) {
    const auto name = nb::cast<std::string>(key);
    const SolverOption* option = find_option(choice.solver(), name);
    if (option == nullptr) reject_keyword(choice, name);
    choice.set(name, value_from(*option, object));
  }
  return choice;
}

nb::dict describe_options(std::string_view solver) {
  const SolverChoice choice(solver);
  nb::dict all;
  for (const SolverOption& option : choice.solver().options) {
    all[nb::cast(option.name)] = nb::make_tuple(std::visit(ToObject(), choice.value(option.name)), option.unit,
                                                expectation(option), option.meaning);
  }
  return all;
}

}  // namespace consimd::python
