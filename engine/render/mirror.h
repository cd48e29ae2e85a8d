// A plane mirror shows the view from the eye's mirror image. Pure functions.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <optional>

#include "engine/contract/mouth_mirror.h"
#include "engine/render/renderer.h"

namespace typodont::render {

/// p ↦ p − 2 n·(p − o) n, with o the glass's middle and n its normal; its own inverse.
glm::dmat4 reflection_in(const Pose& X_WM);

/// The view first reflects the scene: objects before the glass appear as far behind it, at its pixels.
Eye reflected(const Eye& eye, const Pose& X_WM);

/// Only objects before the glass: dot(plane, (p, 1)) ≥ 0.
glm::dvec4 before_glass(const Pose& X_WM);

/// Contains the glass's pixels; empty if out of view or from behind.
std::optional<PixelBox> glass_in(const Eye& eye, const MouthMirror& mirror, const glm::ivec2& size);

/// Rim, stem and handle, in frame M.
ToolMesh make_mirror_body(double diameter);

}  // namespace typodont::render
