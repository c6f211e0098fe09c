#include <consimd/studies/outside_program.hpp>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <iterator>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "outside/child_process.hpp"
#include "outside/reply_text.hpp"

namespace consimd::studies {
namespace {

using Clock = ChildProcess::Clock;
using Answer = ChildProcess::Answer;

constexpr std::string_view kText = "exec:";
constexpr std::string_view kBinary = "exec-binary:";
constexpr std::string_view kReady = "ready";
constexpr double kLongestTime = 1e6;  // seconds, some days; a clock's unit holds it

Clock::time_point deadline_in(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

std::string problem_text(const OutsideProblem& problem) {
  std::string text = fmt::format("{} {} {}\n", problem.source.size() / 3, problem.noise_bound, problem.seed);
  for (std::size_t k = 0; k < problem.source.size(); k += 3) {
    const double* p = problem.source.data() + k;
    const double* q = problem.target.data() + k;
    fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {}\n", p[0], p[1], p[2], q[0], q[1], q[2]);
  }
  return text;
}

template <typename Number>
void append_little_endian(std::string& bytes, Number number) {
  static_assert(sizeof number == 8);
  auto bits = std::bit_cast<std::uint64_t>(number);
  for (int byte = 0; byte < 8; ++byte, bits >>= 8U) bytes.push_back(static_cast<char>(bits & 0xffU));
}

std::string problem_bytes(const OutsideProblem& problem) {
  std::string bytes;
  bytes.reserve(16 * (problem.source.size() + 2));
  append_little_endian(bytes, std::uint64_t{problem.source.size() / 3});
  append_little_endian(bytes, problem.noise_bound);
  append_little_endian(bytes, problem.seed);
  for (std::size_t k = 0; k < problem.source.size(); k += 3) {
    for (std::size_t axis = 0; axis < 3; ++axis) append_little_endian(bytes, problem.source[k + axis]);
    for (std::size_t axis = 0; axis < 3; ++axis) append_little_endian(bytes, problem.target[k + axis]);
  }
  return bytes;
}

/// Programs of one kind that wait for a problem.
class ProgramPool {
 public:
  explicit ProgramPool(OutsideProgram program) : program_(std::move(program)) {
    auto first = start();
    told_version_ = first.version;
    idle_.push_back(std::move(first.process));
  }

  [[nodiscard]] const std::string& version() const noexcept {
    return program_.version.empty() ? told_version_ : program_.version;
  }

  OutsideReply solve(const OutsideProblem& problem) {
    std::unique_ptr<ChildProcess> process = take();
    if (process->has_unread()) wrong(problem, "it wrote more than one line for the problem before");
    const std::string data = program_.binary ? problem_bytes(problem) : problem_text(problem);
    const Clock::time_point start = Clock::now();
    ChildProcess::Reply reply = process->exchange(data, deadline_in(program_.time_limit), program_.stop_requested);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    switch (reply.answer) {
      case Answer::line:
        break;
      case Answer::early:
        wrong(problem, "it replied before it had read the problem: " + shown_text(reply.text));
      case Answer::more:
        wrong(problem, "it wrote more than one line, the first " + shown_text(reply.text));
      case Answer::too_long:
        wrong(problem, "it has no end: " + shown_text(reply.text));
      case Answer::timed_out:
        process->end(false);
        return failed(kTimedOut, fmt::format("no reply within {} s{}", program_.time_limit, so_far(reply.text)),
                      seconds);
      case Answer::stopped:
        process->end(false);
        throw SolverStopped(fmt::format("solver {} on {}: stopped", program_.name, problem.name));
      case Answer::ended:
        return failed(kCrashed, fmt::format("it ended with {}{}", process->end(true), so_far(reply.text)), seconds);
    }
    OutsideReply answer = std::nullopt;
    try {
      const ReplyText text = parse_reply(reply.text);
      answer.pose = text.pose;
      answer.seconds = text.seconds.value_or(seconds);
    } catch (const std::invalid_argument& error) {
      wrong(problem, error.what());
    }
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(process));
    return answer;
  }

 private:
  struct Started {
    std::unique_ptr<ChildProcess> process;
    std::string version;
  };

  /// Waits for the line that says ready; what a program prints before, as some do of themselves, is nobody's.
  Started start() {
    auto process = std::make_unique<ChildProcess>(program_.command);
    const Clock::time_point deadline = deadline_in(program_.time_limit);
    const std::string begun = fmt::format("solver {}: '{}'", program_.name, program_.command);
    std::string first;
    for (;;) {
      ChildProcess::Reply reply = process->exchange({}, deadline, {});
      std::string_view text = reply.text;
      if (text.ends_with('\r')) text.remove_suffix(1);
      const bool whole = reply.answer == Answer::line || reply.answer == Answer::more;
      if (whole && text.starts_with(kReady) && (text.size() == kReady.size() || text[kReady.size()] == ' ')) {
        if (reply.answer == Answer::more) {
          throw std::runtime_error(fmt::format("{} wrote more after the line 'ready'", begun));
        }
        text.remove_prefix(std::min(text.size(), kReady.size() + 1));
        return {std::move(process), printable(text)};
      }
      if (first.empty()) first = reply.text;
      if (whole) continue;
      const std::string said = fmt::format("without the line 'ready'{}",
                                           first.empty() ? "" : fmt::format(", it said {}", shown_text(first)));
      if (reply.answer == Answer::ended) {
        throw std::runtime_error(fmt::format("{} ended with {} {}", begun, process->end(true), said));
      }
      if (reply.answer == Answer::timed_out) {
        throw std::runtime_error(fmt::format("{} ran for {} s {}", begun, program_.time_limit, said));
      }
      throw std::runtime_error(fmt::format("{} ran {}", begun, said));
    }
  }

  /// One that waits, or a new one.
  std::unique_ptr<ChildProcess> take() {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<ChildProcess> process = std::move(idle_.back());
        idle_.pop_back();
        return process;
      }
    }
    Started more = start();
    if (more.version != told_version_) {
      throw std::runtime_error(fmt::format("solver {} told the version {}, now it is {}", program_.name,
                                           shown_text(told_version_), shown_text(more.version)));
    }
    return std::move(more.process);
  }

  static std::string so_far(std::string_view text) {
    return text.empty() ? "" : fmt::format(", in the middle of a line: {}", shown_text(text));
  }

  static OutsideReply failed(std::string_view status, std::string what, double seconds) {
    OutsideReply reply = std::nullopt;
    reply.status = status;
    reply.failure = std::move(what);
    reply.seconds = seconds;
    return reply;
  }

  [[noreturn]] void wrong(const OutsideProblem& problem, const std::string& what) const {
    throw std::runtime_error(fmt::format("solver {} on {}: wrong reply: {}", program_.name, problem.name, what));
  }

  OutsideProgram program_;
  std::string told_version_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<ChildProcess>> idle_;
};

}  // namespace

std::optional<OutsideProgram> parse_outside_program(std::string_view text) {
  const std::size_t end = text.find('=');
  if (end == std::string_view::npos) return std::nullopt;
  OutsideProgram program{.name = std::string(text.substr(0, end)), .command = {}};
  text.remove_prefix(end + 1);
  program.binary = text.starts_with(kBinary);
  if (!program.binary && !text.starts_with(kText)) return std::nullopt;
  text.remove_prefix(program.binary ? kBinary.size() : kText.size());
  if (text.find_first_not_of(" \t\n") == std::string_view::npos) {
    throw std::invalid_argument(fmt::format("solver {}: expected a command after exec:", program.name));
  }
  program.command = text;
  return program;
}

OutsideSolver start_outside_program(const OutsideProgram& program) {
  if (!(program.time_limit > 0.0 && program.time_limit <= kLongestTime)) {
    throw std::invalid_argument(fmt::format("time limit: expected a number of seconds above 0 and at most {}, got {}",
                                            kLongestTime, program.time_limit));
  }
  OutsideSolver solver{.name = program.name,
                       .command = fmt::format("{}{}", program.binary ? kBinary : kText, program.command),
                       .version = {},
                       .time_limit = program.time_limit,
                       .solve = {}};
  require_outside_solvers({solver}, {solver.name});
  const auto pool = std::make_shared<ProgramPool>(program);
  solver.version = pool->version();
  solver.solve = [pool](const OutsideProblem& problem) { return pool->solve(problem); };
  return solver;
}

}  // namespace consimd::studies
