// How a picture shows the scene, and from which viewpoint. Plain data.
#pragma once

#include <cstdint>

#include "engine/contract/tissue.h"
#include "engine/display/display_rig.h"
#include "engine/render/renderer.h"

namespace typodont {

/// Selects what a picture shows. The trainee's picture and the observer's picture can have different looks.
struct Look {
  render::View view = render::View::kLook;
  int section_axis = 1;      // axis perpendicular to the plane of View::kSection: 0 x, 1 y, 2 z
  double section = 0;        // m, position of the section along that axis, from the tooth's middle
  glm::dvec4 plane{0};       // explicit plane of the section, as in render::Frame; zero: use section_axis and section
  std::uint32_t hidden = 0;  // one bit for each hidden tissue; only for View::kLook
  bool tool = true, debris = true, mirror = true, surroundings = true;

  bool operator==(const Look&) const = default;
  bool hides(Tissue tissue) const { return (hidden >> static_cast<unsigned>(tissue) & 1u) != 0; }
};

/// A free viewpoint around the work, without eye tracking.
struct Viewpoint {
  double azimuth = -1.5707963267948966;  // rad, angle about W's z from x to the direction of the viewer
  double elevation = 1.0;                // rad, elevation of the viewer's direction above the horizontal plane
  double distance = 0.15;                // m, distance from the tooth's middle to the viewer
  glm::dvec2 shift{0, 0};                // m, shift of the viewed point to the viewer's right and up
};

/// Limits a viewpoint to valid values: not above the zenith, and outside the tooth.
Viewpoint clamped(const Viewpoint& from);

/// A rig for a picture of this size (pixels) from this viewpoint; the picture shows the surroundings of `middle_W`.
display::DisplayRig rig_of(const Viewpoint& from, const dvec3& middle_W, glm::ivec2 pixels);

/// The viewpoint of a rig's user, within the limits.
Viewpoint viewpoint_of(const display::DisplayRig& rig, const dvec3& middle_W);

/// Section plane of a look for a viewer at p_WE; the tissue on the side away from the viewer is kept. xyz: unit
/// normal, w: m.
glm::dvec4 section_plane(const Look& look, const dvec3& middle_W, const dvec3& p_WE);

}  // namespace typodont
