// A handpiece or handle for pictures, from assets/handpieces/.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont {

/// Circular; the centre is in the plane y = 0.
struct HandpieceRing {
  double x = 0, z = 0;  // m, frame H: x and z of the middle
  double radius = 0;    // m, radius of the circle
};

/// A tube along a path in the plane y = 0, closed at both ends.
struct HandpiecePart {
  std::vector<HandpieceRing> rings;          // at least two, from the tool on
  bool smooth = false;                       // a curve through the rings; false: straight lines
  dvec3 color{0.75, 0.76, 0.78};             // sRGB; metal: of its reflection
  double roughness = 0.3;                    // 0 (mirror) to 1 (dull)
  bool brushed = false;                      // fine grooves around, as turned metal
  bool metal = true;                         // false: plastic or rubber
  double glow = 0;                           // emitted, 0..1
  std::vector<std::array<double, 2>> bands;  // m along the path, of each black band
  // m along the path; equal: no knurl.
  std::array<double, 2> knurl{0, 0};
  double width = 1;  // radius along y / `radius`; 1: round
  int repeat = 1;    // copies around the tool's axis
};

/// Frame H: origin on the tool's axis, z along the shank as in T, body towards +x.
struct Handpiece {
  std::string name;
  // true: origin is the head's centre, drawn instead of the shank; false: holds the shank
  bool from_head = false;
  std::vector<HandpiecePart> parts;
};

/// How handpieces are drawn.
struct HandpieceView {
  bool shown = true;
  bool open = true;  // left out where it would hide the cut
  // rad about the tool's z, from x of T to x of H; −35° points right and to the user
  double roll = -35 * kDegree;
};

}  // namespace typodont
