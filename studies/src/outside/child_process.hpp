// A program that answers lines to what it is sent.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace consimd::studies {

/// Started by /bin/sh in a process group of its own, so that what it starts ends with it, and Ctrl-C reaches the study
/// alone. Where this process is killed, so is the group, a second later. Its standard error stream is that of this
/// process. Not thread-safe.
class ChildProcess {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Answer : std::uint8_t {
    line,       ///< a whole line
    early,      ///< a whole line, before all had been read that was sent
    more,       ///< a line and something behind it
    ended,      ///< the program closed its output first, most often by ending
    timed_out,  ///< there was no whole line in time
    stopped,    ///< nor before `stop` said so
    too_long,   ///< more characters than any reply has, without an end of a line
  };
  struct Reply {
    Answer answer;
    std::string text;  ///< what came, without the end of the line
  };

  /// Throws std::runtime_error if the system starts no process.
  explicit ChildProcess(const std::string& command);
  /// Closes the program's input, and kills what has not ended soon.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Sends `data` and waits for a line, until `deadline` or until `stop`, which is asked every tenth of a second, says
  /// so; none never does. After any answer but `line` the program is of no more use.
  [[nodiscard]] Reply exchange(std::string_view data, Clock::time_point deadline, const std::function<bool()>& stop);

  /// Something that the program wrote unasked.
  [[nodiscard]] bool has_unread();

  /// Kills the program, unless it ends by itself soon where `may_end` is true. How it ended: "exit code 3", "signal 11
  /// (Segmentation fault)".
  std::string end(bool may_end);

 private:
  /// Sends what the pipe takes of `data`; false where nobody reads it any more.
  [[nodiscard]] bool send(std::string_view& data) const;
  /// Takes in what is there; false at the end of the output.
  [[nodiscard]] bool receive();
  void close_input();

  int child_ = -1;
  int input_ = -1;     ///< of the program, this process writes
  int output_ = -1;    ///< of the program, this process reads
  int lifeline_ = -1;  ///< this process writes nothing: its end tells of that of this process
  std::string received_;
  std::optional<std::string> ending_;
};

}  // namespace consimd::studies
