// The trials of a file in the order of their table, also where they are more than memory holds.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include <consimd/studies/trial_table.hpp>

namespace consimd::studies {

/// Rows that are held in memory and sorted at a time, some 300 MB.
inline constexpr std::size_t kRowsInMemory = std::size_t{1} << 20U;

/// Calls `take` with every record of the trials.csv of `table`, in the order of its slots. Of more than
/// `rows_in_memory` the file is first dealt out to files of neighbouring slots, in the same folder and gone at the end.
/// Throws std::runtime_error that names the file, and std::invalid_argument of a bad row.
void for_each_sorted(const std::filesystem::path& trials, const TrialTable& table,
                     const std::function<void(const TrialRecord&)>& take, std::size_t rows_in_memory = kRowsInMemory);

}  // namespace consimd::studies
