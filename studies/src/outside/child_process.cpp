#include "outside/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

extern char** environ;

namespace consimd::studies {
namespace {

using namespace std::chrono_literals;

// Sixteen doubles of 24 characters and a time are 450; a reply in other spelling has room.
constexpr std::size_t kLongestReply = 4096;
constexpr auto kBetweenLooks = 100ms;  // at whether to stop
constexpr auto kGrace = 1s;            // for a program whose input has ended to end itself

[[noreturn]] void fail(const char* what, int error) {
  throw std::runtime_error(fmt::format("cannot {}: {}", what, std::generic_category().message(error)));
}

struct Pipe {
  int read = -1;
  int write = -1;

  Pipe() {
    int ends[2];
    // No other child may inherit an end: a pipe is closed only when all have closed it.
    if (pipe2(ends, O_CLOEXEC) != 0) fail("make a pipe", errno);
    read = ends[0];
    write = ends[1];
  }
  ~Pipe() {
    for (const int end : {read, write}) {
      if (end >= 0) close(end);
    }
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
};

/// Whether a descriptor is ready for `events` or closed, until the deadline.
bool wait_for(pollfd* descriptors, nfds_t count, ChildProcess::Clock::time_point deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - ChildProcess::Clock::now()).count();
    const int timeout = static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000));
    const int ready = poll(descriptors, count, timeout);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) fail("wait for a program", errno);
    if (ready == 0 && ChildProcess::Clock::now() >= deadline) return false;
  }
}

/// While one lives, writing to a closed pipe is an error of the call, not a signal that would end the process.
class NoPipeSignal {
 public:
  NoPipeSignal() : pending_before_(pending()) {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoPipeSignal() {
    if (!pending_before_ && pending()) {
      int taken = 0;
      sigwait(&pipe_, &taken);
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoPipeSignal(const NoPipeSignal&) = delete;
  NoPipeSignal& operator=(const NoPipeSignal&) = delete;

 private:
  static bool pending() {
    sigset_t set;
    sigpending(&set);
    return sigismember(&set, SIGPIPE) == 1;
  }

  sigset_t pipe_;
  sigset_t before_;
  bool pending_before_;
};

/// Nobody ends a program whose study was killed: a hung one would stay. So a process beside it waits for the end of a
/// pipe that this process alone can write to, grants the time that a program has to end by itself and kills the group.
/// It is no child of the program, which may wait for all of its own, and holds none of the program's streams open.
constexpr int kLifeline = 3;
constexpr const char* kShell =
    "( { read -r _; sleep 1; kill -s KILL 0; } <&3 >/dev/null 2>&1 & )\n"
    "exec /bin/sh -c \"$1\" 3<&-";

pid_t spawn(const std::string& command, int input, int output, int lifeline) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, lifeline, kLifeline);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults, none;
  sigemptyset(&defaults);
  sigemptyset(&none);
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) sigaddset(&defaults, signal);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           static_cast<short>(POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK));
  std::string words[] = {"sh", "-c", kShell, "sh", command};
  char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), words[4].data(), nullptr};
  pid_t child = -1;
  const int failed = posix_spawn(&child, "/bin/sh", &files, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (failed != 0) fail("start /bin/sh", failed);
  return child;
}

std::string signal_text(int signal) { return fmt::format("signal {} ({})", signal, strsignal(signal)); }

std::string described(int status) {
  // What a shell adds to the signal that ended its command; 31 are those that every system has.
  constexpr int kOfSignal = 128, kSignals = 31;
  if (WIFSIGNALED(status)) return signal_text(WTERMSIG(status));
  const int code = WEXITSTATUS(status);
  if (code <= kOfSignal || code > kOfSignal + kSignals) return fmt::format("exit code {}", code);
  return fmt::format("exit code {}, {}", code, signal_text(code - kOfSignal));
}

}  // namespace

ChildProcess::ChildProcess(const std::string& command) {
  Pipe input, output, lifeline;
  child_ = spawn(command, input.read, output.write, lifeline.read);
  lifeline_ = std::exchange(lifeline.write, -1);
  input_ = std::exchange(input.write, -1);
  output_ = std::exchange(output.read, -1);
  // A program that does not read must not block this one. The program's end of the pipe stays as it is.
  fcntl(input_, F_SETFL, O_NONBLOCK);
  fcntl(output_, F_SETFL, O_NONBLOCK);
}

ChildProcess::~ChildProcess() {
  end(true);
  close(output_);
  close(lifeline_);
}

void ChildProcess::close_input() {
  if (input_ >= 0) close(std::exchange(input_, -1));
}

bool ChildProcess::send(std::string_view& data) const {
  const NoPipeSignal guard;
  const ssize_t sent = write(input_, data.data(), data.size());
  if (sent > 0) data.remove_prefix(static_cast<std::size_t>(sent));
  return sent >= 0 || errno == EAGAIN || errno == EINTR;
}

bool ChildProcess::receive() {
  char buffer[kLongestReply];
  const ssize_t got = read(output_, buffer, sizeof buffer);
  if (got > 0) received_.append(buffer, static_cast<std::size_t>(got));
  return got > 0 || (got < 0 && (errno == EAGAIN || errno == EINTR));
}

ChildProcess::Reply ChildProcess::exchange(std::string_view data, Clock::time_point deadline,
                                           const std::function<bool()>& stop) {
  for (;;) {
    if (const std::size_t end = received_.find('\n'); end != std::string::npos) {
      std::string line = received_.substr(0, end);
      received_.erase(0, end + 1);
      if (!data.empty()) return {Answer::early, std::move(line)};
      return {received_.empty() ? Answer::line : Answer::more, std::move(line)};
    }
    if (received_.size() > kLongestReply) return {Answer::too_long, received_};
    pollfd descriptors[] = {{output_, POLLIN, 0}, {input_, POLLOUT, 0}};
    const Clock::time_point look = stop ? std::min(deadline, Clock::now() + kBetweenLooks) : deadline;
    if (!wait_for(descriptors, data.empty() ? 1 : 2, look)) {
      if (Clock::now() >= deadline) return {Answer::timed_out, received_};
      if (stop()) return {Answer::stopped, received_};
      continue;
    }
    // Nobody reads: what the program wrote before it ended may still come.
    if (descriptors[1].revents != 0 && !send(data)) data = {};
    if (descriptors[0].revents != 0 && !receive()) return {Answer::ended, received_};
  }
}

bool ChildProcess::has_unread() {
  pollfd output = {output_, POLLIN, 0};
  if (!wait_for(&output, 1, Clock::now())) return !received_.empty();
  static_cast<void>(receive());
  return !received_.empty();
}

std::string ChildProcess::end(bool may_end) {
  if (ending_) return *ending_;
  close_input();
  const auto has_ended = [&] {
    siginfo_t info{};
    // The process stays to be waited for: until then its number, and that of its group, are nobody else's.
    return waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != 0;
  };
  if (may_end) {
    for (const Clock::time_point deadline = Clock::now() + kGrace; !has_ended() && Clock::now() < deadline;) {
      poll(nullptr, 0, 2);
    }
  }
  kill(-child_, SIGKILL);  // and what it has started
  int status = 0;
  pid_t ended = -1;
  do ended = waitpid(child_, &status, 0);
  while (ended < 0 && errno == EINTR);
  ending_ = ended == child_ ? described(status) : "unknown";
  return *ending_;
}

}  // namespace consimd::studies
