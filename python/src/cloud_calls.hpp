// Calls that work on clouds: what they share.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <type_traits>

#include <consimd/kernels/cloud.hpp>

#include "array_arguments.hpp"
#include "interruptible_call.hpp"
#include "threads.hpp"

namespace consimd::python {

using Viewpoint = std::optional<std::array<double, 3>>;

/// A cloud for work that may outlive its caller. Throws as `cloud_from`.
[[nodiscard]] inline std::shared_ptr<const Cloud> shared_cloud(ArrayLike points, std::string_view name,
                                                               std::optional<double> missing) {
  return std::make_shared<const Cloud>(cloud_from(points, name, missing));
}

/// Runs `work` on all threads or fewer, until Ctrl-C; it must own what it uses. What it returns, shared.
template <typename Work>
[[nodiscard]] auto result_of(std::optional<int> threads, const Work& work) {
  using Result = std::invoke_result_t<const Work&>;
  const std::optional<int> limit = checked_threads(threads);
  return interruptible_result<std::shared_ptr<Result>>(
      [limit, work] { return with_threads(limit, [&] { return std::make_shared<Result>(work()); }); });
}

}  // namespace consimd::python
