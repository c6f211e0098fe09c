// How much memory a call needs.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

namespace consimd::bench {

/// Bytes of resident memory at the peak of `call` over those before it. Nothing where the system does not tell; Linux
/// does.
[[nodiscard]] std::optional<std::size_t> peak_memory_bytes(const std::function<void()>& call);

}  // namespace consimd::bench
