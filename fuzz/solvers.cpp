// Every solver with any values of its options, some ended before they begin: an answer that is sound, or an error that
// names the value.
#include <consimd/solvers/solver.hpp>

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <variant>

#include "holds.hpp"
#include "problem_input.hpp"

namespace {

using namespace consimd;

// A budget of a solver is no larger, so that an input takes no seconds.
constexpr std::uint64_t kLargestBudget = 2000;

OptionValue make_value(FuzzedDataProvider& input, const SolverOption& option) {
  struct Maker {
    FuzzedDataProvider& input;
    OptionValue operator()(const TruthRange& /*range*/) const { return input.ConsumeBool(); }
    OptionValue operator()(const WholeRange& range) const {
      const std::uint64_t least = range.least == 0 ? 0 : range.least - 1;  // one that is not allowed, too
      return input.ConsumeIntegralInRange<std::uint64_t>(least, std::max(least, std::min(range.most, kLargestBudget)));
    }
    OptionValue operator()(const RealRange& /*range*/) const {
      return input.ConsumeBool() ? input.ConsumeFloatingPoint<double>() : input.ConsumeProbability<double>();
    }
    OptionValue operator()(const NameRange& range) const {
      return range.names[input.ConsumeIntegralInRange<std::size_t>(0, range.names.size() - 1)];
    }
  };
  if (option.may_be_none && input.ConsumeBool()) return {};
  return std::visit(Maker{input}, option.range);
}

SolverChoice make_choice(FuzzedDataProvider& input) {
  const Solver& solver = solvers()[input.ConsumeIntegralInRange<std::size_t>(0, solvers().size() - 1)];
  SolverChoice choice(solver.name);
  for (const SolverOption& option : solver.options) {
    const bool memory = option.name == "matrix_budget_bytes";  // which has its own least value
    if (!memory && input.ConsumeIntegralInRange<int>(0, 3) == 0) choice.set(option.name, make_value(input, option));
  }
  return choice;
}

void require_sound(const Registration& result, std::size_t rows) {
  using fuzz::require;
  require(result.T_target_source.matrix().allFinite(), "a finite pose");
  const Eigen::Matrix3d rotation = result.T_target_source.linear();
  require(rotation.determinant() > 0.0, "no reflection");
  require((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6, "a rotation");
  require(result.covariance.allFinite() && !std::isnan(result.log10_false_poses), "finite statistics");
  require(std::isfinite(result.scale) && result.scale > 0.0, "a scale above 0");
  require(std::ranges::is_sorted(result.inliers), "inliers in input order");
  require(std::ranges::adjacent_find(result.inliers) == result.inliers.end(), "each inlier once");
  require(result.inliers.empty() || result.inliers.back() < rows, "inliers among the rows");
  if (result.has_pose()) {
    require(result.inliers.size() >= 3, "no pose without support");
  } else {
    require(result.T_target_source.matrix().isIdentity(0.0), "no pose: the identity");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzedDataProvider input(data, size);
  // One thread: what is in flight is what the input says.
  static tbb::task_arena arena(1);
  arena.execute([&] {
    try {
      const SolverChoice choice = make_choice(input);
      SolverOptions options{.seed = input.ConsumeIntegral<std::uint64_t>()};
      options.filter = input.ConsumeBool() ? Filter::tcf : Filter::none;
      options.estimate_scale = input.ConsumeBool();
      static const std::atomic<bool> requested = true;
      if (input.ConsumeIntegralInRange<int>(0, 7) == 0) options.stop.requested = &requested;
      const bool given = input.ConsumeIntegralInRange<int>(0, 7) != 0;  // estimating it takes ten times as long
      const Correspondences correspondences = fuzz::make_correspondences(input, 64);
      if (given) options.noise_bound = fuzz::make_bound(input, correspondences);
      require_sound(register_by_choice(choice, correspondences, options), correspondences.size());
    } catch (const std::invalid_argument&) {
      return;  // as promised of options that cannot be
    }
  });
  return 0;
}
