// Counts length-consistent correspondences of a shifted grid on every instruction set of this machine: all of them.
#include <cstdint>
#include <iostream>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/isa.hpp>
#include <consimd/kernels/length_consistency.hpp>

int main() {
  constexpr std::size_t kPoints = 100;
  std::vector<double> source;
  std::vector<double> target;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double point[] = {static_cast<double>(i % 10), static_cast<double>(i / 10), static_cast<double>(i % 7)};
    for (const double coordinate : point) {
      source.push_back(coordinate);
      target.push_back(coordinate + 3.0);
    }
  }
  const consimd::Correspondences correspondences(consimd::PointSpan<double>::interleaved(source.data(), kPoints),
                                                 consimd::PointSpan<double>::interleaved(target.data(), kPoints));

  const std::vector<std::uint32_t> seeds{0, 42};
  bool all_consistent = true;
  for (const consimd::Isa isa : consimd::supported_isas()) {
    consimd::set_active_isa(isa);
    std::vector<std::uint32_t> counts(seeds.size());
    consimd::length_consistency_counts(correspondences, seeds, 0.01, counts);
    std::cout << consimd::to_string(isa) << ": " << counts[0] << " and " << counts[1] << " of " << kPoints << '\n';
    all_consistent = all_consistent && counts == std::vector<std::uint32_t>(seeds.size(), kPoints);
  }
  return all_consistent ? 0 : 1;
}
