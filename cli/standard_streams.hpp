// The standard streams, which a command must not trust: they may be closed, or lead to a full disk.
#pragma once

#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace consimd::cli {

/// Keeps the descriptors 0 to 2 from files of the command: one that is closed would else be given to the next file that
/// is opened, and what is printed would land in it. Using such a stream fails from here on. Call it first of all.
void occupy_standard_descriptors();

/// Whether somebody reads the standard error stream on a terminal, and lines may be drawn over.
[[nodiscard]] bool error_stream_is_terminal() noexcept;

/// Writes out what was printed. Throws std::runtime_error if that, or any printing before, failed.
void flush_standard_output();

/// Writes to the standard error stream. Where that fails nothing is told: there is nobody to tell it to, and the exit
/// code says the rest.
void tell(std::string_view text) noexcept;

template <typename... Args>
void tell(fmt::format_string<Args...> format, Args&&... args) {
  tell(std::string_view(fmt::format(format, std::forward<Args>(args)...)));
}

}  // namespace consimd::cli
