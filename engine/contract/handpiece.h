// Shape of a handpiece or handle that is drawn, from assets/handpieces/.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont {

/// One circular cross-section; its centre has y = 0.
struct HandpieceRing {
  double x = 0, z = 0;  // m, frame H: x and z of the circle's centre
  double radius = 0;    // m, radius of the circle
};

/// A tube through circular rings, along a path in the plane y = 0, closed at both ends.
struct HandpiecePart {
  std::vector<HandpieceRing> rings;          // at least two, beginning at the tool
  bool smooth = false;                       // true: a smooth curve through the rings; false: straight lines
  dvec3 color{0.75, 0.76, 0.78};             // sRGB, colour of the surface; for metal: colour of its reflections
  double roughness = 0.3;                    // 0 (mirror) to 1 (dull)
  bool brushed = false;                      // true: fine grooves around the tube, as on turned metal
  bool metal = true;                         // false: plastic or rubber
  double glow = 0;                           // brightness of emitted light, 0 to 1
  std::vector<std::array<double, 2>> bands;  // m along the path: start and end of black bands
  // Start and end of the knurled length, m along the path. Equal: no knurl.
  std::array<double, 2> knurl{0, 0};
  double width = 1;  // radius along y, divided by `radius`; 1: round
  int repeat = 1;    // number of copies of the part, evenly around the tool's axis
};

/// Frame H: origin on the tool's axis, z along the shank as in frame T; the handpiece's body lies towards +x.
struct Handpiece {
  std::string name;
  // true: for a hand instrument; the origin is the head's centre, and the handle replaces the tool's shank. false: the
  // handpiece holds the shank
  bool from_head = false;
  std::vector<HandpiecePart> parts;
};

/// How handpieces are drawn.
struct HandpieceView {
  bool shown = true;
  bool open = true;  // true: the handpiece is not drawn where it would hide the cut
  // Angle of the handpiece about the tool's z, from x of T to x of H, rad. −35° points to the right and to the user.
  double roll = -35 * kDegree;
};

}  // namespace typodont
