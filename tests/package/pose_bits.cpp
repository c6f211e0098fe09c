// Prints the bits of registrations: the same, whatever flags the library and this program were built with. The program
// uses the parts of Eigen that the library uses, so that a linker that took the program's copies of them for the
// library's would show.
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <bit>
#include <cstdint>
#include <iostream>
#include <string>

#include <consimd/solvers/gnc_rotation.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

namespace {

/// FNV-1a over the values' bits.
class Bits {
 public:
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(std::uint64_t word) { hash_ = (hash_ ^ word) * 0x100000001b3; }
  template <typename Matrix>
  void add_matrix(const Matrix& m) {
    for (Eigen::Index i = 0; i < m.size(); ++i) add(double{m.data()[i]});
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

std::uint64_t bits_of(const consimd::Registration& registration) {
  Bits bits;
  bits.add_matrix(registration.T_target_source.matrix());
  bits.add_matrix(registration.covariance);
  bits.add(registration.log10_false_poses);
  bits.add(registration.noise_bound);
  for (const std::uint32_t row : registration.inliers) bits.add(std::uint64_t{row});
  return bits.value();
}

/// Far from zero only when the program's own Eigen is broken.
double own_eigen_error() {
  Eigen::Matrix3d m;
  m << 4, 1, 0.5, 1, 3, -0.2, 0.5, -0.2, 2;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(m);
  const Eigen::Matrix3d product = svd.matrixU() * svd.singularValues().asDiagonal() * svd.matrixV().transpose();
  const Eigen::Matrix3Xd points = m.replicate<1, 20>() + Eigen::Matrix3Xd::Identity(3, 60);
  const Eigen::Matrix4d moved = Eigen::umeyama(points, points, false);
  const Eigen::Matrix<double, 6, 6> square = Eigen::Matrix<double, 6, 6>::Identity() * 2.0;
  return (product - m).norm() + std::abs(axes.eigenvalues().sum() - m.trace()) + (moved - moved.Identity()).norm() +
         (square * square.inverse() - square.Identity()).norm();
}

}  // namespace

int main() {
  for (const double outliers : {0.5, 0.95}) {
    const consimd::synth::NoiseStudyOptions study{.correspondences = 1000, .outlier_ratio = outliers, .sigma = 0.3};
    const consimd::synth::Problem problem = consimd::synth::noise_study_problem(study);
    const consimd::Correspondences correspondences = problem.correspondences();
    const double noise_bound = consimd::synth::noise_study_bound(study.sigma);

    for (const std::string& solver : consimd::solver_names()) {
      // Slow on these: mac enumerates cliques, ransac-50k draws all of its samples.
      if (solver == "mac" || solver == "ransac-50k") continue;
      const auto registration = consimd::register_by_name(solver, correspondences, {.noise_bound = noise_bound});
      std::cout << solver << ' ' << outliers << ' ' << std::hex << bits_of(registration) << std::dec << ' '
                << consimd::to_string(registration.status) << ' ' << registration.inliers.size() << '\n';
    }
    Bits truth;
    truth.add_matrix(problem.T_target_source.matrix());
    for (const double x : problem.source) truth.add(x);
    for (const double x : problem.target) truth.add(x);
    truth.add_matrix(consimd::synth::oracle(problem).matrix());
    std::cout << "problem " << outliers << ' ' << std::hex << truth.value() << std::dec << '\n';
  }
  std::cout << "sizes " << sizeof(consimd::Registration) << ' ' << sizeof(consimd::RunnerUp) << ' '
            << sizeof(consimd::GncRotation) << ' ' << sizeof(consimd::Correspondences) << '\n';
  return own_eigen_error() < 1e-12 ? 0 : 1;
}
