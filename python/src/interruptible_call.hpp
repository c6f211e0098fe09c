// Long calls that let other Python threads run and that Ctrl-C ends.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

namespace consimd::python {

struct CallControl {
  /// Makes the work return soon. It is waited for then; work that has no way to be stopped is left behind instead.
  std::function<void()> request_stop = {};
  /// Called about ten times a second with the interpreter's lock held. May throw, which ends the call as Ctrl-C does.
  std::function<void()> look_in = {};
};

/// Runs `work` without the interpreter's lock, on a thread of its own where that is needed to look for signals: only
/// the main thread of Python sees them. A signal whose handler raises, as that of Ctrl-C does, ends the call with that
/// exception within a twentieth of a second, or once `work` has stopped.
///
/// Work left behind goes on until it ends by itself, and the interpreter waits for it when it exits. So `work` must
/// own, or share, all it uses, and hold no Python object. Call it with the interpreter's lock held.
void call_interruptibly(std::function<void()> work, const CallControl& control = {});

template <typename Result>
[[nodiscard]] Result interruptible_result(std::function<Result()> work) {
  const auto result = std::make_shared<std::optional<Result>>();
  call_interruptibly([result, work = std::move(work)] { *result = work(); });
  return std::move(**result);
}

/// Waits for all work left behind. Call it without the interpreter's lock.
void join_work_left_behind();

}  // namespace consimd::python
