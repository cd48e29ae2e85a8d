// The panel and the mirror from a camera's pictures: a full bundle adjustment over camera, lens, every picture's place,
// the panel's place and size, the mirror plane, and points touched with the stylus, which tie all of it to W.
// Without a camera, screen_solver.h does the same from touches alone.
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

/// Pinhole and lens, in pixels; distortion k1, k2, p1, p2, k3 as OpenCV has them.
struct CameraIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<double, 5> distortion{};
};

enum class SeenOn { kTouchedPoint, kPanel, kPanelInMirror };

/// One corner in one picture.
struct Sighting {
  int picture = 0;
  SeenOn on = SeenOn::kPanel;
  PanelPoint corner;         // on the panel
  dvec3 touched_W{0, 0, 0};  // m, a touched point as the stylus gave it; equal ones are one point
  double px = 0, py = 0;     // right and down from the middle of the first pixel
};

struct CameraOptions {
  double touch_sigma = 2e-4;  // m per axis
  double pixel_sigma = 0.1;   // pixels per axis
};

struct CameraResult {
  CameraIntrinsics camera, camera_sigma;
  std::vector<Pose> X_WK;  // the camera (x right, y down, z ahead) in every picture, in order of their numbers
  Panel panel;
  double width = 0, height = 0, width_sigma = 0, height_sigma = 0;  // m
  dvec3 centre_sigma{0, 0, 0};                                      // m
  double tilt_sigma = 0;                                            // rad, worst axis
  std::optional<MirrorPlane> mirror;
  double mirror_tilt_sigma = 0, mirror_offset_sigma = 0;  // rad; m, at the mirror's point below the panel
  double rms_px = 0, worst_px = 0;
  int outliers = 0;  // sightings beyond five pixel sigmas
  double seconds = 0;
  std::string not_determined;  // empty: all of it is
};

/// `start`: the panel as drawn; its size is the first guess. Throws Error without sightings of the panel.
CameraResult solve_camera(std::span<const Sighting> sightings, int width_px, int height_px, const Panel& start,
                          const CameraOptions& options = {});

/// Where a camera sees a point.
struct Pixel {
  double x = 0, y = 0;
};
Pixel project(const CameraIntrinsics& camera, const Pose& X_WK, const dvec3& p_W);

/// picture,on,px,py and u,v (panel) or x_mm,y_mm,z_mm (touched); on: 0 touched, 1 panel, 2 panel in the mirror.
std::vector<Sighting> read_sightings(const std::filesystem::path& file);

/// A chessboard for the panel: where its inner corners are (row by row from the top left; the first cell inside them is
/// dark). columns + rows must be odd, so that the board looks different upside down.
struct BoardPicture {
  int width = 0, height = 0;
  std::vector<unsigned char> grey;
  std::vector<PanelPoint> corners;
};
BoardPicture draw_board(int columns, int rows, int width, int height);

#ifdef TYPODONT_CAMERA
/// The corners of such a board in a picture (OpenCV's detector), in draw_board's order; empty when it is not seen
/// whole. `mirrored`: it is seen in a mirror.
std::vector<Pixel> find_board(const std::filesystem::path& picture, int columns, int rows, bool mirrored);
#endif

}  // namespace typodont::calibration
