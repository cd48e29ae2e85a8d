#include "calibration/solver/late_part.h"
#include "engine/base/guarded_process.h"
#include "engine/base/late_library.h"

namespace typodont::calibration {

namespace {

constexpr const char* kFile = "typodont-calibration.so";
constinit LateLibrary part{kFile, "typodont", [] {
                             return companion_program("TYPODONT_CALIBRATION_PART", kFile, TYPODONT_CALIBRATION_PART,
                                                      "the solvers that need Ceres")
                                 .string();
                           }};
const Late<const LatePart> functions{part, "typodont_calibration_part"};

const LatePart& loaded() {
  return functions;
}

}  // namespace

Pixel project(const CameraIntrinsics& camera, const Pose& X_WK, const dvec3& p_W) {
  return loaded().project_point(camera, X_WK, p_W);
}

CameraResult solve_camera(std::span<const Sighting> sightings, int width_px, int height_px, const Panel& start,
                          const CameraOptions& options) {
  return loaded().camera(sightings, width_px, height_px, start, options);
}

HandEyeResult solve_hand_eye(std::span<const Pose> A, std::span<const Pose> B, const HandEyeOptions& options) {
  return loaded().hand_eye(A, B, options);
}

#ifdef TYPODONT_CAMERA
std::vector<Pixel> find_board(const std::filesystem::path& picture, int columns, int rows, bool mirrored) {
  return loaded().board(picture, columns, rows, mirrored);
}
#endif

}  // namespace typodont::calibration
