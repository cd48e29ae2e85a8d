// The plane mouth mirror: it shows the view from the eye's mirror image. Pure functions.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "engine/contract/mouth_mirror.h"
#include "engine/render/renderer.h"

namespace typodont::render {

/// Reflection p ↦ p − 2 n·(p − o) n (o: middle of the glass, n: its normal); its own inverse.
glm::dmat4 reflection_in(const Pose& X_WM);

/// View of the eye in the mirror. It first reflects the scene in the glass, so objects in front of the glass appear as
/// far behind the glass, at the pixels of the glass.
Eye reflected(const Eye& eye, const Pose& X_WM);

/// Clip plane: only objects in front of the glass fulfil dot(plane, (p, 1)) ≥ 0.
glm::dvec4 before_glass(const Pose& X_WM);

/// Box that contains the glass's pixels; nullopt if it is not visible, or seen from behind.
std::optional<PixelBox> glass_in(const Eye& eye, const MouthMirror& mirror, const glm::ivec2& size);

/// Mesh of rim, stem and handle in frame M.
ToolMesh make_mirror_body(double diameter);

}  // namespace typodont::render
