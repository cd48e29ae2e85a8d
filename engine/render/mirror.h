// The mouth mirror: what an eye sees in a plane glass is what an eye reflected in it would see. Pure functions.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "engine/contract/mouth_mirror.h"
#include "engine/render/renderer.h"

namespace typodont::render {

/// p ↦ p − 2 n·(p − o) n, for the glass's middle o and normal n. Its own inverse.
glm::dmat4 reflection_in(const Pose& X_WM);

/// The same eye, looking at the scene as the glass shows it: its view reflects the scene first, so what stands before
/// the glass appears as far behind it, at the pixel where the glass is.
Eye reflected(const Eye& eye, const Pose& X_WM);

/// What is drawn of the reflected scene: only what stands before the glass. xyz: normal, w: so that dot ≥ 0 there.
glm::dvec4 before_glass(const Pose& X_WM);

/// Pixels of a picture of this size that the glass can cover for this eye: a box (x, y, width, height), generous;
/// nothing when the glass is out of view or shows its back.
std::optional<PixelBox> glass_in(const Eye& eye, const MouthMirror& mirror, const glm::ivec2& size);

/// Rim, stem and handle, in M.
ToolMesh make_mirror_body(double diameter);

}  // namespace typodont::render
