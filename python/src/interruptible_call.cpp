#include "interruptible_call.hpp"

#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include <nanobind/nanobind.h>

namespace consimd::python {
namespace nb = nanobind;
namespace {

/// Shared by the caller and the working thread: whichever ends last destroys it.
class Job {
 public:
  explicit Job(std::function<void()> work) : work_(std::move(work)) {}

  void run() noexcept {
    std::exception_ptr error;
    try {
      work_();
    } catch (...) {
      error = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    error_ = error;
    ended_ = true;
    change_.notify_all();
  }

  /// Whether the work has ended.
  bool wait_for(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    return change_.wait_for(lock, time, [this] { return ended_; });
  }

  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::function<void()> work_;
  std::mutex mutex_;
  std::condition_variable change_;
  bool ended_ = false;
  std::exception_ptr error_;
};

/// Threads whose callers have gone, of the process `owner`: a fork has none of them. Never destroyed, since a thread
/// that runs cannot be.
struct LeftBehind {
  std::mutex mutex;
  std::vector<std::thread> threads;
  pid_t owner = getpid();
};

LeftBehind& left_behind() {
  static auto* all = new LeftBehind;
  return *all;
}

bool on_main_thread() {
  const nb::object main = nb::module_::import_("threading").attr("main_thread")();
  return nb::cast<unsigned long>(main.attr("ident")) == PyThread_get_thread_ident();
}

}  // namespace

void call_interruptibly(std::function<void()> work, const CallControl& control) {
  if (!control.look_in && !on_main_thread()) {
    const nb::gil_scoped_release unlocked;
    work();
    return;
  }
  const auto job = std::make_shared<Job>(std::move(work));
  std::thread thread([job] { job->run(); });
  constexpr std::chrono::milliseconds kBetweenLooks(50);
  try {
    for (int look = 0;; ++look) {
      {
        const nb::gil_scoped_release unlocked;
        if (job->wait_for(kBetweenLooks)) break;
      }
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      if (control.look_in && look % 2 == 1) control.look_in();
    }
  } catch (...) {
    if (control.request_stop) {
      control.request_stop();
      const nb::gil_scoped_release unlocked;
      thread.join();
    } else {
      const std::lock_guard lock(left_behind().mutex);
      left_behind().threads.push_back(std::move(thread));
    }
    throw;
  }
  {
    const nb::gil_scoped_release unlocked;
    thread.join();
  }
  job->rethrow();
}

void join_work_left_behind() {
  if (left_behind().owner != getpid()) return;
  const std::lock_guard lock(left_behind().mutex);
  for (std::thread& thread : left_behind().threads) thread.join();
  left_behind().threads.clear();
}

}  // namespace consimd::python
