// Enumerations, which Python takes by name.
#pragma once

#include <string>
#include <string_view>

#include <nanobind/nanobind.h>

namespace consimd::python {

template <typename Enum>
struct Named {
  std::string_view name;
  Enum value;
};
template <typename Enum>
Named(const char*, Enum) -> Named<Enum>;

/// Specialised with an array `kValues` of all names.
template <typename Enum>
struct NamedValues;

/// Throws nanobind::value_error that lists the known names. what: the argument's name.
template <typename Enum>
[[nodiscard]] Enum value_named(std::string_view name, std::string_view what) {
  std::string known;
  for (const Named<Enum>& named : NamedValues<Enum>::kValues) {
    if (named.name == name) return named.value;
    known.append(known.empty() ? "" : ", ").append(named.name);
  }
  throw nanobind::value_error(
      (std::string(what) + " is '" + std::string(name) + "', expected one of: " + known).c_str());
}

template <typename Enum>
[[nodiscard]] std::string_view name_of(Enum value) {
  for (const Named<Enum>& named : NamedValues<Enum>::kValues) {
    if (named.value == value) return named.name;
  }
  return "unknown";
}

}  // namespace consimd::python
