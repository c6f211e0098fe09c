// A solver of one's own in consimd's studies, on the same problems as consimd's: RANSAC on three points that fits and
// counts with Eigen, here in place of yours.
#include <iostream>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/compare_options.hpp>
#include <consimd/studies/paper_tables.hpp>
#include <consimd/studies/sweep.hpp>

namespace studies = consimd::studies;

namespace {

using Points = Eigen::Map<const Eigen::Matrix3Xd>;

/// Pose that maps the chosen source points to their targets with the least squares of distances.
consimd::RigidTransform fit(const Points& source, const Points& target, const std::vector<Eigen::Index>& rows) {
  const Eigen::Matrix4d pose = Eigen::umeyama(source(Eigen::all, rows), target(Eigen::all, rows), false);
  consimd::RigidTransform result;
  result.matrix() = pose;
  return result;
}

/// The rows whose points a pose brings within the noise bound of each other.
std::vector<Eigen::Index> supporters(const Points& source, const Points& target, const consimd::RigidTransform& pose,
                                     double noise_bound) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < source.cols(); ++row) {
    if ((pose * source.col(row) - target.col(row)).norm() <= noise_bound) rows.push_back(row);
  }
  return rows;
}

/// A pose, or nothing. A consimd::Registration would do as well.
std::optional<consimd::RigidTransform> my_solver(const studies::OutsideProblem& problem) {
  const auto size = static_cast<Eigen::Index>(problem.source.size() / 3);
  const Points source(problem.source.data(), 3, size), target(problem.target.data(), 3, size);
  if (size < 3) return std::nullopt;
  std::mt19937_64 random(problem.seed);
  std::uniform_int_distribution<Eigen::Index> any_row(0, size - 1);
  std::vector<Eigen::Index> best;
  for (int sample = 0; sample < 200; ++sample) {
    const consimd::RigidTransform pose = fit(source, target, {any_row(random), any_row(random), any_row(random)});
    std::vector<Eigen::Index> rows = supporters(source, target, pose, problem.noise_bound);
    if (rows.size() > best.size()) best = std::move(rows);
  }
  if (best.size() <= 3) return std::nullopt;  // any three points fit
  return fit(source, target, best);
}

}  // namespace

int main() {
  const studies::OutsideSolvers mine{{.name = "mine", .version = "1.0", .solve = my_solver}};

  studies::SweepOptions study;
  study.points = {300};
  study.outlier_ratios = {0.5, 0.8};
  study.sigmas = {0.1, 1.0};
  study.trials = 5;
  study.solvers = {"mine", "tcf"};
  study.outside = mine;
  studies::TrialTable table(study);
  studies::run_sweep(table);  // in the threads of the caller's oneTBB arena
  std::cout << "solver  outliers  recall  rotation error, deg\n";
  for (const studies::RatioSummary& row : studies::summarise(table).ratios()) {
    std::cout << row.solver << "\t" << row.outlier_ratio << "\t  " << row.recall_mean << "\t  "
              << row.error.rotation_deg << "\n";
  }

  studies::CompareOptions compared;
  compared.synthetic = {"facade"};
  compared.trials = 3;
  compared.tables.solvers = {"mine", "tcf"};
  compared.tables.outside = mine;
  studies::Comparison comparison = studies::make_comparison(compared);
  studies::run_comparison(comparison);
  const studies::ComparisonResults results = studies::comparison_results(compared.tables, comparison);
  for (const studies::TextTable& text : results.tables) {
    std::cout << "\n" << studies::to_markdown(text);
  }
  return table.complete() && comparison.complete() ? 0 : 1;
}
