// Every kernel on every instruction set of the processor against the scalar reference: equal bits.
#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/angle_consistency.hpp>
#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/isa.hpp>
#include <consimd/kernels/length_consistency.hpp>
#include <consimd/kernels/length_ratio.hpp>
#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/kernels/three_point_fit.hpp>

#include <bit>
#include <cstring>

#include "holds.hpp"
#include "problem_input.hpp"

namespace {

using namespace consimd;

/// All results of all kernels, as bytes.
class Results {
 public:
  template <typename T>
  void add(const T& value) {
    const auto* const bytes = reinterpret_cast<const unsigned char*>(&value);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof value);
  }
  template <typename T>
  void add(const std::vector<T>& values) {
    for (const T& value : values) add(value);
  }
  bool operator==(const Results&) const = default;

 private:
  std::vector<unsigned char> bytes_;
};

struct Arguments {
  double bound = 1.0;
  double ratio_bound = 0.1;
  std::vector<std::uint32_t> rows;
  std::vector<IndexPair> pairs;
  std::vector<IndexTriple> triples;
  RobustWeight weight;
};

Arguments make_arguments(FuzzedDataProvider& input, const Correspondences& correspondences) {
  Arguments arguments;
  arguments.bound = fuzz::make_bound(input, correspondences);
  arguments.ratio_bound = input.ConsumeProbability<double>();
  const auto last = static_cast<std::uint32_t>(correspondences.size() - 1);
  const auto row = [&] { return input.ConsumeIntegralInRange<std::uint32_t>(0, last); };
  for (int k = input.ConsumeIntegralInRange<int>(0, 9); k > 0; --k) {
    arguments.rows.push_back(row());
    arguments.pairs.push_back({row(), row()});
    arguments.triples.push_back({row(), row(), row()});
  }
  arguments.weight = {.function = input.PickValueInArray(
                          {WeightFunction::truncated, WeightFunction::cauchy, WeightFunction::student_uniform}),
                      .scale = arguments.bound,
                      .cutoff = 2.0 * arguments.bound,
                      .odds = input.ConsumeProbability<double>(),
                      .exponent = input.PickValueInArray({2U, 4U, 8U, 16U, 32U, 64U})};
  return arguments;
}

Results run(const CorrespondenceView& view, const Arguments& a) {
  Results results;
  const std::size_t hypotheses = a.rows.size();
  std::vector<std::uint32_t> counts(hypotheses);
  std::vector<std::uint64_t> bits(hypotheses * view.words());
  std::vector<WorkingPose> poses(hypotheses);
  std::vector<PoseSupport> support(hypotheses);
  std::vector<float> costs(hypotheses), squared(view.padded_size()), highs(view.padded_size());
  length_consistency_counts(view, a.rows, a.bound, counts);
  results.add(counts);
  length_consistency_bits(view, a.rows, a.bound, bits, counts);
  results.add(bits);
  angle_consistency_counts(view, a.pairs, a.bound, counts);
  results.add(counts);
  angle_consistency_bits(view, a.pairs, a.bound, bits, counts);
  results.add(bits);
  three_point_fits(view, a.triples, poses);
  results.add(poses);
  alignment_scores(view, poses, a.bound, support);
  results.add(support);
  alignment_bits(view, poses, a.bound, bits, counts);
  results.add(bits);
  if (a.ratio_bound > 0.0 && a.ratio_bound < 1.0) {
    length_disagreement(view, a.rows, a.bound, a.ratio_bound, costs);
    results.add(costs);
  }
  ConsistencyMatrix matrix;
  matrix.compute(view, a.bound);
  results.add(std::vector<std::uint64_t>(matrix.data(), matrix.data() + matrix.size() * matrix.words()));
  matrix.compute_separated(view, a.bound, 2.0 * a.bound);
  results.add(std::vector<std::uint64_t>(matrix.data(), matrix.data() + matrix.size() * matrix.words()));
  for (std::size_t h = 0; h < hypotheses; ++h) {
    scale_intervals(view, a.rows[h], a.bound, squared, highs);
    results.add(squared);
    results.add(highs);
    alignment_residuals(view, poses[h], squared);
    results.add(squared);
    const RigidMoments moments = robust_moments(view, poses[h], a.weight);
    results.add(moments);
    results.add(subset_moments(view, std::span(bits).subspan(h * view.words(), view.words())));
  }
  return results;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzedDataProvider input(data, size);
  const Correspondences correspondences = fuzz::make_correspondences(input, 200);
  if (correspondences.empty()) return 0;
  const Arguments arguments = make_arguments(input, correspondences);
  set_active_isa(Isa::scalar);
  Results expected;
  try {
    expected = run(correspondences, arguments);
  } catch (const std::invalid_argument&) {
    return 0;  // a bound that is no length
  }
  for (const Isa isa : supported_isas()) {
    set_active_isa(isa);
    fuzz::require(run(correspondences, arguments) == expected, "equal bits on every instruction set");
  }
  return 0;
}
