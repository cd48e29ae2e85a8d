// A mirror bench before it is built: panel, mirror, eyes, arm, glass, workspace. Pure, any thread, SI. W: origin in the
// tissue, x right, y away, z up; the picture appears there, the panel is its mirror image.
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
  double eye_distance = 0.5;  // m from the tissue
  double ipd = 0.063;         // m, interpupillary distance
  double gaze = 0;            // rad, angle of the line of sight below the horizontal
  // rad from the horizontal, far edge up
  double mirror_tilt = 0;
  double picture_tilt = 0;      // rad; π/2: upright
  double glass_above_work = 0;  // m, distance of the glass from the origin, along its normal
  dvec3 arm_box{0, 0, 0};       // m, reach of the arm, centred
  double hand_room = 0.04;      // m between workspace and glass
  double head_room = 0.1;       // m, clearance between the eyes and the panel
  // dioptres from the picture, the eye's depth of focus (Campbell 1957)
  double comfort = 0.3;
};

/// With the limit that sets it.
struct Face {
  dvec3 outward{0, 0, 0};
  std::string limit;  // name of the limit: "the arm", "the picture's left edge", …
};

struct BenchPlan {
  DisplayRig rig;  // panel, mirror and eyes; the arm's middle is at the origin
  Screen picture;  // the panel's mirror image, where the user sees the picture
  /// m, W: near left, near right, far right, far left
  std::array<dvec3, 4> glass{};
  double glass_width = 0, glass_length = 0;  // m, width and length of the smallest glass
  dvec3 low{0, 0, 0}, high{0, 0, 0};         // m, W; equal: no box
  std::array<Face, 6> faces;                 // faces in the order -x, +x, -y, +y, -z, +z
  double nearest = 0, farthest = 0;          // m, nearest and farthest comfortable distance from the eyes
  double pixel = 0;                          // m, width of a pixel of one eye's picture
  std::vector<std::string> conflicts;        // empty: can be built
};

BenchPlan plan_bench(const BenchSpec& spec);

}  // namespace typodont::display
