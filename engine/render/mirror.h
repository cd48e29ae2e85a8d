// The mouth mirror. What an eye sees in a plane mirror is the view of the scene from the mirror image of this eye. Pure
// functions.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "engine/contract/mouth_mirror.h"
#include "engine/render/renderer.h"

namespace typodont::render {

/// Returns the matrix of the reflection p ↦ p − 2 n·(p − o) n in the mirror's plane, where o is the middle of the glass
/// and n its normal. The reflection is its own inverse.
glm::dmat4 reflection_in(const Pose& X_WM);

/// Returns the same eye with a view of the reflected scene. The view matrix first reflects the scene. So an object in
/// front of the glass appears at the same distance behind the glass, at the pixels of the glass.
Eye reflected(const Eye& eye, const Pose& X_WM);

/// Returns the clip plane for the reflected scene: only objects in front of the glass are drawn. xyz: normal; w:
/// offset. Points in front of the glass have dot(plane, (p, 1)) ≥ 0.
glm::dvec4 before_glass(const Pose& X_WM);

/// Returns a box (x, y, width, height) that contains all pixels of the glass for this eye, in a picture of this size.
/// No value if the glass is out of view or shows its back.
std::optional<PixelBox> glass_in(const Eye& eye, const MouthMirror& mirror, const glm::ivec2& size);

/// Returns the mesh of rim, stem and handle, in the mirror's frame M.
ToolMesh make_mirror_body(double diameter);

}  // namespace typodont::render
