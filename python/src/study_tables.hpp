// Tables of studies as NumPy arrays, and how long studies run under Python.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>

#include <consimd/studies/solver_comparison.hpp>
#include <consimd/studies/table_columns.hpp>
#include "array_results.hpp"
#include "interruptible_call.hpp"
#include "threads.hpp"

namespace consimd::python {

/// A column as an array, or as a list of str.
template <typename Rows, typename Column>
[[nodiscard]] nb::object to_array(const Rows& rows, const Column& column) {
  using Value = std::remove_cvref_t<decltype(column.value(*rows.begin()))>;
  if constexpr (std::is_same_v<Value, std::string>) {
    nb::list list;
    for (const auto& row : rows) list.append(column.value(row));
    return list;
  } else {
    // A vector of bool holds no array.
    std::vector<std::conditional_t<std::is_same_v<Value, bool>, std::uint8_t, Value>> values;
    values.reserve(rows.size());
    for (const auto& row : rows) values.push_back(column.value(row));
    const std::size_t size = values.size();
    return nb::cast(to_array<Array<Value, -1>>(std::move(values), {size}));
  }
}

/// Columns by name, from left to right.
template <typename Rows, typename Columns>
[[nodiscard]] nb::dict to_columns(const Rows& rows, const Columns& columns) {
  nb::dict arrays;
  studies::for_each_column(columns,
                           [&](const auto& column) { arrays[nb::cast(column.name)] = to_array(rows, column); });
  return arrays;
}

/// The tables of solvers beside each other, in the order of their files: pairs, solvers, curves.
template <typename Cell>
[[nodiscard]] nb::tuple to_tables(const studies::SolverComparison<Cell>& comparison) {
  return nb::make_tuple(to_columns(comparison.pairs, studies::kPairColumns<Cell>),
                        to_columns(comparison.solvers, studies::kSolverColumns<Cell>),
                        to_columns(comparison.curves, studies::kCurveColumns<Cell>));
}

/// What the columns of a table mean, by name.
template <typename Columns>
[[nodiscard]] nb::dict meanings(const Columns& columns) {
  nb::dict texts;
  studies::for_each_column(columns, [&](const auto& column) { texts[nb::cast(column.name)] = column.meaning; });
  return texts;
}

/// Runs `work(stop_requested, step)` without the interpreter's lock: it calls `step` as each of its `total` units ends,
/// of which `done_before` are done already, and returns soon when `stop_requested`, which is `stop`, is true.
/// `progress`, unless it is None, is told the numbers of units done and of all some ten times a second and in the end;
/// what it raises, and Ctrl-C, ends the work. `threads` as `checked_threads` returned it.
template <typename Work>
void run_study(std::size_t done_before, std::size_t total, std::optional<int> threads, const nb::object& progress,
               std::atomic<bool>& stop, const Work& work) {
  std::atomic<std::size_t> done = done_before;
  const auto tell = [&] {
    if (!progress.is_none()) progress(done.load(), total);
  };
  // Waited for in every case, so it may use what is on this stack.
  call_interruptibly([&] { with_threads(threads, [&] { work([&] { return stop.load(); }, [&] { ++done; }); }); },
                     {.request_stop = [&] { stop = true; }, .look_in = tell});
  tell();
}

}  // namespace consimd::python
