#include <consimd/synth/problem_files.hpp>

#include <charconv>
#include <cstddef>
#include <fstream>
#include <ios>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace consimd::synth {
namespace {

namespace fs = std::filesystem;

/// A file under a temporary name: renamed by `commit`, else removed.
class PendingFile {
 public:
  PendingFile(fs::path path, const std::string& text) : path_(std::move(path)), temporary_(path_) {
    temporary_ += ".partial";
    std::ofstream stream(temporary_, std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) {
      remove_temporary();
      throw std::runtime_error("cannot write " + path_.string());
    }
  }
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile() { remove_temporary(); }

  void commit() {
    std::error_code error;
    fs::rename(temporary_, path_, error);
    if (error) throw std::runtime_error("cannot write " + path_.string() + ": " + error.message());
  }

 private:
  void remove_temporary() const noexcept {
    std::error_code ignored;  // after `commit` there is nothing to remove
    fs::remove(temporary_, ignored);
  }

  fs::path path_;
  fs::path temporary_;
};

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

std::string labels_text(const Problem& problem) {
  std::string text;
  for (const std::uint8_t label : problem.is_inlier) text += label != 0 ? "1\n" : "0\n";
  return text;
}

}  // namespace

void write_problem(const Problem& problem, const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error("cannot make folder " + folder.string() + ": " + error.message());

  PendingFile correspondences(folder / "correspondences.txt", correspondences_text(problem));
  PendingFile pose(folder / "pose.txt", pose_text(problem.T_target_source, problem.scale));
  PendingFile labels(folder / "labels.txt", labels_text(problem));
  correspondences.commit();
  pose.commit();
  labels.commit();
}

}  // namespace consimd::synth
