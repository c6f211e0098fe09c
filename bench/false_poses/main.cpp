// How often a solver takes something for a pose where there is none, kind by kind. Prints a table in Markdown, each
// number as it is measured.
#include <oneapi/tbb/parallel_for.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <consimd/solvers/registry.hpp>
#include <consimd/solvers/solver.hpp>

#include "problem_kinds.hpp"

namespace consimd::bench {
namespace {

constexpr const char* kUsage =
    "consimd_false_poses [PROBLEMS [KIND [SOLVER [bound|none [SEED [ROWS]]]]]]\n"
    "  PROBLEMS   of each kind and number of rows (40)\n"
    "  KIND       kinds whose name contains it (\"\": all)\n"
    "  SOLVER     its name, with options if any (tcf)\n"
    "  bound      the noise bound is given; none: it is estimated from the rows\n"
    "  SEED       of the generator (1)\n"
    "  ROWS       of a problem, numbers separated by commas (10,30,100,300,1000,3000)\n"
    "Recorded pairs take part where CONSIMD_TEST_DATA names the folder that has their sets.\n";

struct Request {
  std::uint64_t problems = 40;
  std::string name;
  SolverChoice solver{std::string_view("tcf")};
  bool bound_is_given = true;
  std::uint64_t seed = 1;
  std::vector<std::size_t> rows{10, 30, 100, 300, 1000, 3000};
};

std::uint64_t whole(const char* name, const std::string& text) {
  std::size_t used = 0;
  unsigned long long value = 0;
  try {
    value = std::stoull(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || text.front() == '-' || value == 0) {
    throw std::invalid_argument(
        fmt::format("{} is '{}', expected a whole number above 0; --help tells all", name, text));
  }
  return value;
}

Request request_of(const std::vector<std::string>& arguments) {
  Request request;
  if (arguments.size() > 6) throw std::invalid_argument("more than six arguments");
  if (!arguments.empty()) request.problems = whole("PROBLEMS", arguments[0]);
  if (arguments.size() > 1) request.name = arguments[1];
  if (arguments.size() > 2) request.solver = SolverChoice(std::string_view(arguments[2]));
  if (arguments.size() > 3) {
    if (arguments[3] != "bound" && arguments[3] != "none") {
      throw std::invalid_argument(fmt::format("'{}', expected bound or none", arguments[3]));
    }
    request.bound_is_given = arguments[3] == "bound";
  }
  if (arguments.size() > 4) request.seed = whole("SEED", arguments[4]);
  if (arguments.size() > 5) {
    request.rows.clear();
    std::istringstream list(arguments[5]);
    for (std::string rows; std::getline(list, rows, ',');) request.rows.push_back(whole("ROWS", rows));
    if (request.rows.empty()) throw std::invalid_argument("ROWS is empty, expected whole numbers above 0");
  }
  return request;
}

// `success` and `ambiguous` among problems of one kind and number of rows.
struct Count {
  std::uint64_t successes = 0;
  std::uint64_t ambiguous = 0;
};

Count count(const ProblemKind& kind, const Request& request, std::size_t rows) {
  std::vector<Status> statuses(request.problems);
  tbb::parallel_for(std::uint64_t{0}, request.problems, [&](std::uint64_t trial) {
    const NoPose problem = kind.make(rows, trial);
    const std::optional<double> bound = request.bound_is_given ? std::optional(problem.noise_bound) : std::nullopt;
    statuses[trial] =
        register_by_choice(request.solver, problem.correspondences, {.noise_bound = bound, .seed = trial + 1}).status;
  });
  Count result;
  for (const Status status : statuses) {
    result.successes += status == Status::success || status == Status::budget_exhausted ? 1 : 0;
    result.ambiguous += status == Status::ambiguous ? 1 : 0;
  }
  return result;
}

void print_table(const Request& request) {
  std::vector<ProblemKind> kinds = synthetic_kinds(request.seed);
  if (const char* const data = std::getenv("CONSIMD_TEST_DATA")) {
    for (ProblemKind& kind : recorded_kinds(case_folders(data), request.seed)) kinds.push_back(std::move(kind));
  }
  std::erase_if(kinds, [&](const ProblemKind& kind) { return kind.name.find(request.name) == std::string::npos; });
  if (kinds.empty()) throw std::invalid_argument(fmt::format("no kind has '{}' in its name", request.name));
  fmt::print("| kind |");
  for (const std::size_t rows : request.rows) fmt::print(" {} rows |", rows);
  fmt::print(" `success` | `ambiguous` |\n| --- |");
  for (std::size_t column = 0; column < request.rows.size() + 2; ++column) fmt::print(" --: |");
  fmt::print("\n");
  for (const ProblemKind& kind : kinds) {
    fmt::print("| {} |", kind.name);
    Count sum;
    for (const std::size_t rows : request.rows) {
      const Count found = count(kind, request, rows);
      sum.successes += found.successes;
      sum.ambiguous += found.ambiguous;
      fmt::print(" {} |", found.successes);
      std::fflush(stdout);
    }
    fmt::print(" {} of {} | {} |\n", sum.successes, request.rows.size() * request.problems, sum.ambiguous);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace consimd::bench

int main(int argc, char** argv) try {
  if (argc > 1 && (std::string_view(argv[1]) == "--help" || std::string_view(argv[1]) == "-h")) {
    fmt::print("{}", consimd::bench::kUsage);
    return 0;
  }
  consimd::bench::print_table(consimd::bench::request_of({argv + 1, argv + argc}));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "consimd_false_poses: %s\n", error.what());
  return 2;
}
