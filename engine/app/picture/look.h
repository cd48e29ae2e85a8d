// How a picture of a session shows the scene, and from where whoever watches looks at it. Plain data.
#pragma once

#include <cstdint>

#include "engine/contract/tissue.h"
#include "engine/display/display_rig.h"
#include "engine/render/renderer.h"

namespace typodont {

/// What of the scene a picture shows. Two of these may differ at a time: the trainee's, and that of who watches.
struct Look {
  render::View view = render::View::kLook;
  int section_axis = 1;      // 0 x, 1 y, 2 z: what the plane of View::kSection stands across
  double section = 0;        // m from the tooth's middle, along that axis
  glm::dvec4 plane{0};       // the section's own plane instead, as render::Frame has it; zero: none
  std::uint32_t hidden = 0;  // View::kLook: a bit per tissue that is left out
  bool tool = true, debris = true, mirror = true, surroundings = true;

  bool operator==(const Look&) const = default;
  bool hides(Tissue tissue) const { return (hidden >> static_cast<unsigned>(tissue) & 1u) != 0; }
};

/// A viewpoint of one's own, around the work. It belongs to no eye that is tracked.
struct Viewpoint {
  double azimuth = -1.5707963267948966;  // rad about W's z, from x: where the viewer stands
  double elevation = 1.0;                // rad above the horizon
  double distance = 0.15;                // m
  glm::dvec2 shift{0, 0};                // m, of what is looked at: to the viewer's right, up
};

/// Within what can be looked from: never through the zenith, never into the tooth.
Viewpoint clamped(const Viewpoint& from);

/// The rig of a picture of these pixels that shows what is around `middle_W` from there.
display::DisplayRig rig_of(const Viewpoint& from, const dvec3& middle_W, glm::ivec2 pixels);

/// Where a rig's user looks from, as far as one can stand there.
Viewpoint viewpoint_of(const display::DisplayRig& rig, const dvec3& middle_W);

/// The plane of a look's section for a viewer at p_WE: tissue on the far side stays. xyz: unit normal, w: m.
glm::dvec4 section_plane(const Look& look, const dvec3& middle_W, const dvec3& p_WE);

}  // namespace typodont
