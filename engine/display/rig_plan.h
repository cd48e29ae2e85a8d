// Plans a mirror bench before it is built: the positions of panel, mirror, eyes and arm, the size of the glass, and the
// size of the workspace that both eyes see and that the arm reaches. Pure functions for any thread. SI units.
// Frame W: origin in the middle of the tissue, x to the user's right, y away from the user, z up. The user looks down
// at the tissue through the half mirror, along the line of sight from the eyes to the origin. The picture appears at
// the origin; the panel is its mirror image.
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
  double eye_distance = 0.5;  // m, distance from the midpoint between the eyes to the origin of W (the tissue)
  double ipd = 0.063;         // m, interpupillary distance
  double gaze = 0;            // rad, angle of the line of sight below the horizontal
  // rad, angle between the half mirror and the horizontal; positive if the mirror's far edge is higher than its near
  // edge
  double mirror_tilt = 0;
  double picture_tilt = 0;      // rad, angle between the picture and the horizontal; π/2 for an upright picture
  double glass_above_work = 0;  // m, distance of the glass from the origin, along its normal
  dvec3 arm_box{0, 0, 0};       // m, width, depth and height of the region that the arm reaches, centred at the origin
  double hand_room = 0.04;      // m, clearance between workspace and glass for the hand above the tool
  double head_room = 0.1;       // m, clearance between the eyes and the panel
  // dioptres, largest allowed difference in focus between the picture and an object that appears in front of the
  // picture or behind it. The value is the depth of focus of the eye (Campbell 1957).
  double comfort = 0.3;
};

/// A face of the common workspace, and the limit of the arm or the picture that determines its position.
struct Face {
  dvec3 outward{0, 0, 0};
  std::string limit;  // name of the limit: "the arm", "the picture's left edge", …
};

struct BenchPlan {
  DisplayRig rig;  // panel, mirror and eyes; the arm's middle is at the origin
  Screen picture;  // the panel's mirror image, where the user sees the picture
  /// m, frame W: corners of the smallest glass: near left, near right, far right, far left
  std::array<dvec3, 4> glass{};
  double glass_width = 0, glass_length = 0;  // m, width and length of the smallest glass
  dvec3 low{0, 0, 0}, high{0, 0, 0};         // m, frame W: the largest box inside all limits; low = high: no box exists
  std::array<Face, 6> faces;                 // faces in the order -x, +x, -y, +y, -z, +z
  double nearest = 0, farthest = 0;          // m, nearest and farthest comfortable distance from the eyes
  double pixel = 0;                          // m, width of a pixel of one eye's picture
  std::vector<std::string> conflicts;        // reasons why this bench cannot be built; empty: it can be built
};

BenchPlan plan_bench(const BenchSpec& spec);

}  // namespace typodont::display
