// Finds panel and mirror from pictures of a camera. Bundle adjustment: camera, lens, poses, panel and mirror are solved
// together. Points touched by the arm relate them to the world frame W. Without a camera, see screen_solver.h.
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

/// Camera matrix in pixels; distortion k1, k2, p1, p2, k3 as in OpenCV.
struct CameraIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<double, 5> distortion{};
};

enum class SeenOn { kTouchedPoint, kPanel, kPanelInMirror };

/// A corner of the board, or a touched point, in one picture.
struct Sighting {
  int picture = 0;
  SeenOn on = SeenOn::kPanel;
  PanelPoint corner;  // position of the corner on the panel
  // Touched point, m; equal values mean the same point.
  dvec3 touched_W{0, 0, 0};
  double px = 0, py = 0;  // pixels to the right and down, from the first pixel's centre
};

struct CameraOptions {
  double touch_sigma = 2e-4;  // m per axis, standard deviation of a touched point
  double pixel_sigma = 0.1;   // pixels per axis, standard deviation of a sighting
};

struct CameraResult {
  CameraIntrinsics camera, camera_sigma;
  // Pose of the camera in the world frame W for each picture. Camera frame K: x right, y down, z forward.
  std::vector<Pose> X_WK;
  Panel panel;
  // Size of the panel and its standard deviations, m.
  double width = 0, height = 0, width_sigma = 0, height_sigma = 0;
  /// m per axis, standard deviation of the panel's centre
  dvec3 centre_sigma{0, 0, 0};
  // Standard deviation of the panel's rotation about its least certain axis, rad.
  double tilt_sigma = 0;
  std::optional<MirrorPlane> mirror;
  // Standard deviations of the mirror: tilt (rad), and position along its normal below the panel (m).
  double mirror_tilt_sigma = 0, mirror_offset_sigma = 0;
  double rms_px = 0, worst_px = 0;
  int outliers = 0;  // number of sightings with a residual above 5 pixel_sigma
  double seconds = 0;
  std::string not_determined;  // parameters that the pictures do not determine; empty: none
};

/// Solves for camera, panel and mirror. `start`: approximate panel. Throws Error if no picture shows the panel.
CameraResult solve_camera(std::span<const Sighting> sightings, int width_px, int height_px, const Panel& start,
                          const CameraOptions& options = {});

/// A position in a picture of the camera.
struct Pixel {
  double x = 0, y = 0;
};
Pixel project(const CameraIntrinsics& camera, const Pose& X_WK, const dvec3& p_W);

/// Reads columns picture,on,px,py and u,v (panel) or x_mm,y_mm,z_mm (touched point). `on`: 0 touched point, 1 panel, 2
/// panel in the mirror.
std::vector<Sighting> read_sightings(const std::filesystem::path& file);

/// Picture of a chessboard, and its inner corners, row by row from the top left. The first inner cell is dark. columns
/// + rows is odd, so that a rotation by 180° can be recognised.
struct BoardPicture {
  int width = 0, height = 0;
  std::vector<unsigned char> grey;
  std::vector<PanelPoint> corners;
};
BoardPicture draw_board(int columns, int rows, int width, int height);

#ifdef TYPODONT_CAMERA
/// Finds the corners with OpenCV, in the order of draw_board(); empty unless all are visible. `mirrored`: the picture
/// shows the board in a mirror.
std::vector<Pixel> find_board(const std::filesystem::path& picture, int columns, int rows, bool mirrored);
#endif

}  // namespace typodont::calibration
