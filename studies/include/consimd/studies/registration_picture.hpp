// A registration to look at: clouds and correspondences before and after the pose.
#pragma once

#include <string>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// What is drawn. Borrows; both clouds or none must be there. Without clouds the points of the correspondences are
/// drawn in their place.
struct RegistrationPicture {
  const Correspondences* correspondences = nullptr;
  const Registration* registration = nullptr;  ///< of these correspondences
  const Cloud* source = nullptr;
  const Cloud* target = nullptr;
  /// Names for people, such as the clouds' files; the second is empty where one file holds the correspondences.
  std::string source_name = {};
  std::string target_name = {};
  std::string solver = {};
};

/// One self-contained HTML page that needs no network, but a browser with WebGL 2: the clouds before and after the
/// pose, and with the runner-up where there is one, the inliers and outliers as lines; without a pose the clouds as
/// given. Of a cloud at most 200 000 points are drawn, means of voxels; of inliers and of outliers at most 10 000 each,
/// evenly chosen; the page says so where it left some out. Coordinates are stored in single precision about the middle
/// of their cloud. The same registration gives the same bytes: there are no times in it.
/// Throws std::invalid_argument where correspondences or registration are missing, the registration has inliers that
/// the correspondences have not, or one cloud is given without the other or is empty.
[[nodiscard]] std::string registration_page(const RegistrationPicture& picture);

/// The same as one SVG drawing, before beside after, seen as the page shows it first. At most 5000 points of a cloud
/// and 200 lines of a kind are drawn. Throws as above.
[[nodiscard]] std::string registration_svg(const RegistrationPicture& picture);

}  // namespace studies
}  // namespace consimd
