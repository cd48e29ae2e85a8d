// Plans a mirror bench before it is built. Any thread; SI units. W: origin in the tissue, x right, y away from the
// user, z up. The picture appears at the origin; the panel is its mirror image.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/display/display_rig.h"

namespace typodont::display {

struct BenchSpec {
  double panel_width = 0, panel_height = 0;  // m, size of the panel's lit area
  ivec2 pixels{1920, 1080};
  Layout layout = Layout::kSideBySide;
  double eye_distance = 0.5;  // m, distance of the eyes from the tissue
  double ipd = 0.063;         // m, interpupillary distance
  double gaze = 0;            // rad, angle of the line of sight below the horizontal
  // Angle of the glass to the horizontal, rad; its far edge is higher.
  double mirror_tilt = 0;
  double picture_tilt = 0;      // rad, angle of the picture to the horizontal; π/2: upright
  double glass_above_work = 0;  // m, distance of the glass from the origin, along the glass's normal
  dvec3 arm_box{0, 0, 0};       // m, size of the arm's reach, centred at the origin
  double hand_room = 0.04;      // m, free space for the hand between workspace and glass
  double head_room = 0.1;       // m, smallest distance between the eyes and the panel
  // Largest comfortable distance between picture and hand, dioptres: the eye's depth of focus (Campbell 1957).
  double comfort = 0.3;
};

/// A face of the workspace, with the limit that determines its position.
struct Face {
  dvec3 outward{0, 0, 0};
  std::string limit;  // name of the limit: "the arm", "the picture's left edge"
};

struct BenchPlan {
  DisplayRig rig;  // panel, mirror and eyes; the arm lies around the origin
  Screen picture;  // the panel's mirror image, where the user sees the picture
  /// Corners of the glass, m, frame W: near left, near right, far right, far left.
  std::array<dvec3, 4> glass{};
  double glass_width = 0, glass_length = 0;  // m, width and length of the smallest glass
  dvec3 low{0, 0, 0}, high{0, 0, 0};         // m, frame W, corners of the workspace; equal: no workspace
  std::array<Face, 6> faces;                 // faces in the order -x, +x, -y, +y, -z, +z
  double nearest = 0, farthest = 0;          // m, nearest and farthest comfortable distance from the eyes
  double pixel = 0;                          // m, width of a pixel of one eye's picture
  std::vector<std::string> conflicts;        // reasons why this mirror bench cannot be built; empty: it can
};

BenchPlan plan_bench(const BenchSpec& spec);

}  // namespace typodont::display
