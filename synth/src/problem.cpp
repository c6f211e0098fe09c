#include <consimd/synth/problem.hpp>

namespace consimd::synth {

Correspondences Problem::correspondences() const {
  return {PointSpan<double>::interleaved(source.data(), source.size() / 3),
          PointSpan<double>::interleaved(target.data(), target.size() / 3)};
}

}  // namespace consimd::synth
