#include <consimd/synth/problem_files.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/synth/noise_study.hpp>
#include <consimd/synth/pending_file.hpp>

#include "correspondence_rows.hpp"
#include "number_table.hpp"

namespace consimd::synth {
namespace {

namespace fs = std::filesystem;

/// Digits that read back as the same double, whatever the locale.
void append_number(std::string& text, double value) {
  char digits[32];
  const std::to_chars_result end = std::to_chars(std::begin(digits), std::end(digits), value);
  text += std::string_view(digits, end.ptr);
}

void append_row(std::string& text, std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text += ' ';
    append_number(text, values[i]);
  }
}

std::string correspondences_text(const Problem& problem) {
  std::string text = "# source_x source_y source_z target_x target_y target_z\n";
  for (std::size_t k = 0; k < problem.size(); ++k) {
    append_row(text, std::span(problem.source).subspan(3 * k, 3));
    text += ' ';
    append_row(text, std::span(problem.target).subspan(3 * k, 3));
    text += '\n';
  }
  return text;
}

std::string labels_text(const Problem& problem) {
  std::string text;
  for (const std::uint8_t label : problem.is_inlier) text += label != 0 ? "1\n" : "0\n";
  return text;
}

/// What the problem is and when it counts as solved. The limits are the pose errors that alone would bring the true
/// inliers' RMSE to 3 sigma: 3 sigma^2 of it are noise, so sqrt(6) sigma remain for a shift or a turn.
std::string case_text(const Problem& problem) {
  const double bound = noise_study_bound(problem.sigma);
  const double shift = std::sqrt(6.0) * problem.sigma;
  std::size_t within = 0;
  std::vector<Eigen::Vector3d> inliers;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const Eigen::Map<const Eigen::Vector3d> source(problem.source.data() + 3 * k);
    const Eigen::Map<const Eigen::Vector3d> target(problem.target.data() + 3 * k);
    if ((problem.T_target_source * (problem.scale * source) - target).norm() < bound) ++within;
    if (problem.is_inlier[k] == 0) continue;
    inliers.emplace_back(problem.scale * source);
    centre += inliers.back();
  }
  const auto count = std::max(1.0, static_cast<double>(inliers.size()));
  double squares = 0.0;
  for (const Eigen::Vector3d& p : inliers) squares += (p - centre / count).squaredNorm();
  const double lever = std::sqrt(squares / count * 2.0 / 3.0);  // RMS distance from an axis, mean over the axes
  const double half_turn = std::numbers::pi;
  const auto degrees = std::min(shift / std::max(lever, shift / half_turn), half_turn) * 180.0 / std::numbers::pi;

  std::string text = "{\n \"dataset\": \"consimd synth\"";
  const auto add = [&text](std::string_view name, double value) {
    text.append(",\n \"").append(name).append("\": ");
    append_number(text, value);
  };
  add("correspondences", static_cast<double>(problem.size()));
  add("noise_bound", bound);
  add("inliers_within_noise_bound", static_cast<double>(within));
  add("max_rotation_error_deg", degrees);
  add("max_translation_error_m", shift);
  if (problem.scale != 1.0) add("scale", problem.scale);
  return text + "\n}\n";
}

/// What the readers of the files refuse is not written.
void require_finite(const Problem& problem) {
  for (const std::vector<double>* const cloud : {&problem.source, &problem.target}) {
    for (std::size_t i = 0; i < cloud->size(); ++i) {
      if (std::isfinite((*cloud)[i])) continue;
      throw std::invalid_argument("row " + std::to_string(i / 3) + " of the " +
                                  (cloud == &problem.source ? "source" : "target") + " is not finite");
    }
  }
  if (!problem.T_target_source.matrix().allFinite() || !std::isfinite(problem.scale)) {
    throw std::invalid_argument("the pose is not finite");
  }
}

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error(shown_name(path) + ": " + what);
}

/// Three significant digits.
std::string rounded(double value) {
  char digits[32];
  const std::to_chars_result end =
      std::to_chars(std::begin(digits), std::end(digits), value, std::chars_format::general, 3);
  return {digits, end.ptr};
}

constexpr const char* kReflection = "not a rotation but a reflection: its determinant is negative";

// Products of poses and text of single precision leave as much in the last row.
constexpr double kLastRowRounding = 1e-6;

using Matrix34 = Eigen::Matrix<double, 3, 4>;

Matrix34 matrix_of(std::span<const double> numbers, const fs::path& path) {
  if (numbers.size() == 16 &&
      !((Eigen::Map<const Eigen::RowVector4d>(numbers.data() + 12) - Eigen::RowVector4d(0, 0, 0, 1))
            .cwiseAbs()
            .maxCoeff() <= kLastRowRounding)) {
    fail(path, "the last row must be 0 0 0 1");
  }
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers.data());
}

/// tx ty tz qx qy qz qw.
Matrix34 matrix_of_quaternion(std::span<const double> numbers, const fs::path& path) {
  constexpr double kTolerance = 1e-3;
  const double x = numbers[3], y = numbers[4], z = numbers[5], w = numbers[6];
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(std::abs(norm - 1.0) <= kTolerance)) fail(path, "a quaternion of length " + rounded(norm) + ", expected 1");
  Matrix34 matrix;
  matrix.leftCols<3>() = Eigen::Quaterniond(w / norm, x / norm, y / norm, z / norm).toRotationMatrix();
  matrix.col(3) << numbers[0], numbers[1], numbers[2];
  return matrix;
}

// What messages about a pose of another form end with.
constexpr const char* kMatrixForm = ": write the matrix [R t], 3 or 4 rows of 4 numbers";

/// One pose in any of the forms of `read_pose`.
Matrix34 read_matrix(const fs::path& path) {
  const NumberTable table = read_number_table(path);
  if (!table.names.empty()) fail(path, std::string("a line of names, expected a pose") + kMatrixForm);
  const std::span<const double> all(table.values);
  const std::size_t rows = table.rows();
  const auto is = [&](std::size_t k, std::size_t width) { return table.row(k).size() == width; };
  const auto all_are = [&](std::size_t begin, std::size_t end, std::size_t width) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!is(k, width)) return false;
    }
    return true;
  };
  constexpr std::size_t kLogged = 5;  // lines of a pose of gt.log
  std::size_t poses = 1;
  for (const std::size_t width : {7u, 8u, 12u, 16u}) {
    if (rows > 0 && all_are(0, rows, width)) poses = rows;
  }
  if (rows > kLogged && rows % kLogged == 0 && is(0, 3) && is(kLogged, 3)) poses = rows / kLogged;
  const auto require_no_commas = [&] {
    for (const std::size_t width : {4u, 7u, 8u, 12u, 16u}) require_no_decimal_commas(table, width, path);
  };
  if (poses > 1) {
    require_no_commas();
    fail(path, std::to_string(poses) + " poses, expected the one of the pair");
  }
  if (rows == 1 && (is(0, 12) || is(0, 16))) return matrix_of(all, path);
  if (rows == 1 && (is(0, 7) || is(0, 8))) return matrix_of_quaternion(all.last(7), path);
  if (rows == kLogged && is(0, 3) && all_are(1, kLogged, 4)) return matrix_of(all.subspan(3), path);
  require_no_commas();
  require_columns(table, 4, path, kMatrixForm);
  if (rows != 3 && rows != 4) fail(path, "expected 3 or 4 rows, got " + std::to_string(rows) + kMatrixForm);
  return matrix_of(all, path);
}

/// U V^T with the order of each sum written out: Eigen's depends on how it was told to vectorise, and a pose that is
/// read from a file must have the same bits in every build. The last row has always been summed from its end.
Eigen::Matrix3d product_with_transpose(const Eigen::Matrix3d& U, const Eigen::Matrix3d& V) {
  Eigen::Matrix3d product;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      const double a = U(row, 0) * V(column, 0), b = U(row, 1) * V(column, 1), c = U(row, 2) * V(column, 2);
      product(row, column) = row < 2 ? (a + b) + c : a + (b + c);
    }
  }
  return product;
}

/// That of a matrix that is one but for rounding, whose file is named where it is not.
RigidTransform pose_of(const fs::path& path, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  try {
    return nearest_pose(rotation, translation);
  } catch (const std::invalid_argument& error) {
    fail(path, error.what());
  }
}

}  // namespace

RigidTransform nearest_pose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  constexpr double kTolerance = 1e-3;
  const double deviation = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation <= kTolerance)) {
    throw std::invalid_argument("not a rotation: R R^T is " + rounded(deviation) + " off the identity");
  }
  if (rotation.determinant() < 0.0) throw std::invalid_argument(kReflection);

  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  RigidTransform result = RigidTransform::Identity();
  result.linear() = product_with_transpose(svd.matrixU(), svd.matrixV());
  result.translation() = translation;
  return result;
}

void write_problem(const Problem& problem, const fs::path& folder) {
  require_finite(problem);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error("cannot make folder " + folder.string() + ": " + error.message());

  PendingFile correspondences(folder / "correspondences.txt", correspondences_text(problem));
  PendingFile pose(folder / "pose.txt", pose_text(problem.T_target_source, problem.scale));
  PendingFile labels(folder / "labels.txt", labels_text(problem));
  std::optional<PendingFile> case_file;
  if (problem.sigma > 0.0) case_file.emplace(folder / "case.json", case_text(problem));
  correspondences.commit();
  pose.commit();
  labels.commit();
  if (case_file) case_file->commit();
}

std::string pose_text(const RigidTransform& pose, double scale) {
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = pose.matrix();
  rows.topLeftCorner<3, 3>() *= scale;
  std::string text;
  for (std::size_t row = 0; row < 4; ++row) {
    append_row(text, std::span(rows.data() + 4 * row, 4));
    text += '\n';
  }
  return text;
}

void write_pose(const RigidTransform& pose, double scale, const fs::path& path) {
  PendingFile(path, pose_text(pose, scale)).commit();
}

Correspondences read_correspondences(const fs::path& path, std::span<const std::size_t> columns) {
  if (!columns.empty() && (columns.size() != 6 || std::ranges::find(columns, std::size_t{0}) != columns.end())) {
    throw std::invalid_argument("columns: expected six of them, counted from 1");
  }
  const CorrespondenceRows rows = read_correspondence_rows(path, columns);
  const PointSpan<double> source{rows.values.data(), rows.size(), 6, 1};
  const PointSpan<double> target{rows.values.data() + 3, rows.size(), 6, 1};
  return {source, target};
}

RigidTransform read_pose(const fs::path& path) {
  const Matrix34 matrix = read_matrix(path);
  return pose_of(path, matrix.leftCols<3>(), matrix.col(3));
}

ScaledPose read_scaled_pose(const fs::path& path) {
  const Matrix34 matrix = read_matrix(path);
  const double scale = elementary::cbrt(matrix.leftCols<3>().determinant());
  if (scale < 0.0) fail(path, kReflection);
  if (!(scale > 0.0) || !std::isfinite(scale)) fail(path, "its scale is " + rounded(scale) + ", expected one above 0");
  return {pose_of(path, matrix.leftCols<3>() / scale, matrix.col(3)), scale};
}

Problem labelled_problem(std::vector<double> source, std::vector<double> target, const RigidTransform& T_target_source,
                         double noise_bound) {
  Problem problem;
  problem.source = std::move(source);
  problem.target = std::move(target);
  problem.T_target_source = T_target_source;
  for (std::size_t k = 0; k < problem.source.size(); k += 3) {
    const Eigen::Map<const Eigen::Vector3d> p(problem.source.data() + k), q(problem.target.data() + k);
    problem.is_inlier.push_back((T_target_source * p - q).norm() < noise_bound ? 1 : 0);
  }
  return problem;
}

Problem read_problem(const fs::path& correspondences, const fs::path& pose, double noise_bound) {
  const CorrespondenceRows rows = read_correspondence_rows(correspondences, {});
  std::vector<double> source, target;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const double* const numbers = rows.values.data() + 6 * row;
    source.insert(source.end(), numbers, numbers + 3);
    target.insert(target.end(), numbers + 3, numbers + 6);
  }
  return labelled_problem(std::move(source), std::move(target), read_pose(pose), noise_bound);
}

}  // namespace consimd::synth
