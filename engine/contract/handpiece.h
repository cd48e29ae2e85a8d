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
  std::vector<HandpieceRing> rings;  // at least two rings; the first ring is the one nearest to the tool
  bool smooth = false;               // true: a smooth curve through the rings; false: straight lines between them
  dvec3 color{0.75, 0.76, 0.78};     // sRGB; the reflectance of metal
  double roughness = 0.3;            // 0..1
  bool brushed = false;              // true: fine grooves around the part, as on turned metal
  bool metal = true;                 // false: plastic or rubber
  double glow = 0;                   // 0..1, light that the part emits
  std::vector<std::array<double, 2>> bands;  // m, begin and end of each black band, along the path from the first ring
  // m, begin and end of the knurl, along the path from the first ring; equal: no knurl
  std::array<double, 2> knurl{0, 0};
  double width = 1;  // factor of the radius along y; 1: round
  int repeat = 1;    // number of copies, spaced evenly around the tool's axis
};

/// Frame H: its origin is on the tool's axis, its z points along the shank as in T, and the body extends from the
/// head towards +x.
struct Handpiece {
  std::string name;
  bool from_head =
      // true: H begins at the centre of the tool's head, and the handpiece replaces the tool's shank; false: the
      // handpiece holds the shank
      false;
  std::vector<HandpiecePart> parts;
};

/// How a scene shows handpieces.
struct HandpieceView {
  bool shown = true;
  bool open = true;  // true: the handpiece is not drawn where it hides the cut from an eye
  // rad, rotation about the tool's z, from x of T to x of H; at −35° the handpiece points to the right and to the
  // user
  double roll = -35 * kDegree;
};

}  // namespace typodont
