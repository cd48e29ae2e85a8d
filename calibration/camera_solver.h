// Calibrates the panel and the mirror from a camera's pictures. A bundle adjustment estimates the camera and its
// lens, the pose of every picture, the panel's pose and size, and the mirror plane. Points touched with the stylus
// relate these results to W. Without a camera, screen_solver.h uses touches alone.
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

/// Pinhole and lens parameters in pixels; distortion k1, k2, p1, p2, k3 as in OpenCV.
struct CameraIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<double, 5> distortion{};
};

enum class SeenOn { kTouchedPoint, kPanel, kPanelInMirror };

/// One point (a corner of the panel's board, or a touched point) that is visible in one picture.
struct Sighting {
  int picture = 0;
  SeenOn on = SeenOn::kPanel;
  PanelPoint corner;  // position of the corner on the panel
  // m, position of a touched point; sightings (corners in pictures) with equal `touched_W` show the same point
  dvec3 touched_W{0, 0, 0};
  double px = 0, py = 0;  // pixels, position to the right of and below the centre of the first pixel
};

struct CameraOptions {
  double touch_sigma = 2e-4;  // m per axis, standard deviation of the noise of a touched position
  double pixel_sigma = 0.1;   // pixels per axis, standard deviation of the noise of a corner's position
};

struct CameraResult {
  CameraIntrinsics camera, camera_sigma;
  // poses of the camera's frame K (x right, y down, z forward) in frame W, one for each picture, in the order of the
  // pictures' numbers
  std::vector<Pose> X_WK;
  Panel panel;
  // m, width and height of the panel's picture, and their standard deviations
  double width = 0, height = 0, width_sigma = 0, height_sigma = 0;
  /// m per axis, standard deviation of the panel's centre
  dvec3 centre_sigma{0, 0, 0};
  // rad, standard deviation of the panel's tilt about the axis for which this standard deviation is largest
  double tilt_sigma = 0;
  std::optional<MirrorPlane> mirror;
  // mirror_tilt_sigma: rad, standard deviation of the mirror's tilt; mirror_offset_sigma: m, standard deviation of the
  // mirror's position along its normal, at the point of the mirror below the panel
  double mirror_tilt_sigma = 0, mirror_offset_sigma = 0;
  double rms_px = 0, worst_px = 0;
  int outliers = 0;  // number of corners in pictures (sightings) with a residual above five times pixel_sigma
  double seconds = 0;
  std::string not_determined;  // parameters that the pictures do not determine; empty: none
};

/// Calibrates from sightings (corners that pictures show). `start`: the nominal panel, used as the initial guess.
/// Throws Error if there are no sightings of the panel.
CameraResult solve_camera(std::span<const Sighting> sightings, int width_px, int height_px, const Panel& start,
                          const CameraOptions& options = {});

/// A position in a picture of the camera.
struct Pixel {
  double x = 0, y = 0;
};
Pixel project(const CameraIntrinsics& camera, const Pose& X_WK, const dvec3& p_W);

/// Reads sightings (corners in pictures). Columns picture,on,px,py and u,v (panel) or x_mm,y_mm,z_mm (touched). `on`: 0
/// touched point, 1 panel, 2 panel in the mirror.
std::vector<Sighting> read_sightings(const std::filesystem::path& file);

/// A chessboard to show on the panel, with the positions of its inner corners (row by row from the top left; the first
/// cell inside the inner corners is dark). columns + rows must be odd, so that the board and the board rotated by 180°
/// are different.
struct BoardPicture {
  int width = 0, height = 0;
  std::vector<unsigned char> grey;
  std::vector<PanelPoint> corners;
};
BoardPicture draw_board(int columns, int rows, int width, int height);

#ifdef TYPODONT_CAMERA
/// Finds the corners of a board from draw_board() in a picture, with OpenCV's detector. Returns the corners in the
/// order of draw_board(); empty unless the whole board is visible. `mirrored`: true if the picture shows the board in a
/// mirror.
std::vector<Pixel> find_board(const std::filesystem::path& picture, int columns, int rows, bool mirrored);
#endif

}  // namespace typodont::calibration
