// A handpiece or the handle of a hand instrument, as pictures show it: the data of a file in assets/handpieces/.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"

namespace typodont {

/// A circle of the surface of a part, in the part's plane y = 0.
struct HandpieceRing {
  double x = 0, z = 0;  // m, middle of the circle
  double radius = 0;    // m
};

/// A tube along a path in the plane y = 0. Both ends are closed.
struct HandpiecePart {
  std::vector<HandpieceRing> rings;          // at least two, from the tool outwards
  bool smooth = false;                       // a smooth curve through the rings; false: straight between them
  dvec3 color{0.75, 0.76, 0.78};             // sRGB; the reflectance of metal
  double roughness = 0.3;                    // 0..1
  bool brushed = false;                      // true: fine grooves around the part, as turned metal has
  bool metal = true;                         // false: plastic or rubber
  double glow = 0;                           // 0..1, light that the part emits
  std::vector<std::array<double, 2>> bands;  // m from the first ring along the path: black bands
  std::array<double, 2> knurl{0, 0};         // m from the first ring: knurled range; equal: none
  double width = 1;                          // factor of the radius along y; 1: round
  int repeat = 1;                            // copies, evenly around the tool's axis
};

/// Frame H: origin on the tool's axis, z along the shank as in T; the body leaves the head towards +x.
struct Handpiece {
  std::string name;
  bool from_head =
      false;  // H begins at the centre of the tool's head and replaces its shank; false: it holds the shank
  std::vector<HandpiecePart> parts;
};

/// How a scene shows handpieces.
struct HandpieceView {
  bool shown = true;
  bool open = true;             // the handpiece is left out where it hides the cut from an eye
  double roll = -35 * kDegree;  // rad about the tool's z, from x of T to x of H; −35°: to the right and to the user
};

}  // namespace typodont
