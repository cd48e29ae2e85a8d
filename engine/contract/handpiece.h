// The shape of a handpiece or of a hand instrument's handle for pictures. The shape is read from a file in
// assets/handpieces/.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont {

/// A circular cross-section of a part. Its centre lies in the plane y = 0.
struct HandpieceRing {
  double x = 0, z = 0;  // m, frame H of the handpiece: x and z of the circle's middle
  double radius = 0;    // m, radius of the circle
};

/// A part of a handpiece: a tube along a path in the plane y = 0. Both ends are closed.
struct HandpiecePart {
  std::vector<HandpieceRing> rings;  // at least two rings; the first ring is the one nearest to the tool
  bool smooth = false;               // true: a smooth curve through the rings; false: straight lines between them
  dvec3 color{0.75, 0.76, 0.78};     // sRGB colour; for metal, the colour of its reflection
  double roughness = 0.3;            // roughness of the surface, 0 (mirror) to 1 (dull)
  bool brushed = false;              // true: fine grooves around the part, as on turned metal
  bool metal = true;                 // false: plastic or rubber
  double glow = 0;                   // brightness of the light that the part emits, 0..1
  std::vector<std::array<double, 2>> bands;  // m, begin and end of each black band, along the path from the first ring
  // Begin and end of the knurl in m, along the path from the first ring. If both are equal, the part has no knurl.
  std::array<double, 2> knurl{0, 0};
  double width = 1;  // ratio of the tube's radius along y to `radius`; 1: round
  int repeat = 1;    // number of copies of the part, spaced evenly around the tool's axis
};

/// A handpiece in its frame H. The origin of H is on the tool's axis, z points along the shank as in the tool's frame
/// T, and the body extends from the head towards +x.
struct Handpiece {
  std::string name;
  // true: the origin of H is the centre of the tool's head, and the handpiece is drawn instead of the tool's shank.
  // false: the handpiece holds the shank.
  bool from_head = false;
  std::vector<HandpiecePart> parts;
};

/// States how a scene draws handpieces.
struct HandpieceView {
  bool shown = true;
  bool open = true;  // true: where the handpiece would hide the cut from an eye, it is not drawn
  // rad, rotation angle about the tool's z axis, from the x axis of the tool's frame T to the x axis of the handpiece's
  // frame H. At −35° the handpiece points to the right and to the user.
  double roll = -35 * kDegree;
};

}  // namespace typodont
