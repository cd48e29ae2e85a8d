// Panel and mirror from a camera's pictures: bundle adjustment of camera, lens, poses, panel and mirror. Touched points
// relate them to W. Without a camera: screen_solver.h.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/rig_geometry.h"

namespace typodont::calibration {

/// Pixels; distortion k1, k2, p1, p2, k3 as in OpenCV.
struct CameraIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<double, 5> distortion{};
};

enum class SeenOn { kTouchedPoint, kPanel, kPanelInMirror };

/// A board corner or touched point in one picture.
struct Sighting {
  int picture = 0;
  SeenOn on = SeenOn::kPanel;
  PanelPoint corner;  // position of the corner on the panel
  // m; equal values are the same point
  dvec3 touched_W{0, 0, 0};
  double px = 0, py = 0;  // right of and below the centre of the first pixel
};

struct CameraOptions {
  double touch_sigma = 2e-4;  // m per axis
  double pixel_sigma = 0.1;   // pixels per axis
};

struct CameraResult {
  CameraIntrinsics camera, camera_sigma;
  // per picture; K: x right, y down, z forward
  std::vector<Pose> X_WK;
  Panel panel;
  // m, and their σ
  double width = 0, height = 0, width_sigma = 0, height_sigma = 0;
  /// m per axis, standard deviation of the panel's centre
  dvec3 centre_sigma{0, 0, 0};
  // rad, largest over all axes
  double tilt_sigma = 0;
  std::optional<MirrorPlane> mirror;
  // rad; m along the normal, below the panel
  double mirror_tilt_sigma = 0, mirror_offset_sigma = 0;
  double rms_px = 0, worst_px = 0;
  int outliers = 0;  // sightings with a residual above 5 pixel_sigma
  double seconds = 0;
  std::string not_determined;  // parameters that the pictures do not determine; empty: none
};

/// `start`: the nominal panel. Throws Error without sightings of the panel.
CameraResult solve_camera(std::span<const Sighting> sightings, int width_px, int height_px, const Panel& start,
                          const CameraOptions& options = {});

/// A position in a picture of the camera.
struct Pixel {
  double x = 0, y = 0;
};
Pixel project(const CameraIntrinsics& camera, const Pose& X_WK, const dvec3& p_W);

/// Columns picture,on,px,py and u,v (panel) or x_mm,y_mm,z_mm (touched); `on`: 0 touched, 1 panel, 2 panel in the
/// mirror.
std::vector<Sighting> read_sightings(const std::filesystem::path& file);

/// A chessboard and its inner corners, row by row from the top left, the first inner cell dark. columns + rows is odd,
/// so that a turn by 180° shows.
struct BoardPicture {
  int width = 0, height = 0;
  std::vector<unsigned char> grey;
  std::vector<PanelPoint> corners;
};
BoardPicture draw_board(int columns, int rows, int width, int height);

#ifdef TYPODONT_CAMERA
/// Corners in the order of draw_board(), by OpenCV; empty unless all are visible. `mirrored`: seen in a mirror.
std::vector<Pixel> find_board(const std::filesystem::path& picture, int columns, int rows, bool mirrored);
#endif

}  // namespace typodont::calibration
