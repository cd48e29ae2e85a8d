// Light that surfaces receive from the room and from each other: computed once for static bodies by casting rays on the
// CPU, and stored in a grid that the shaders sample (shaders/lighting.glsl). The lamp's own light is not part of it.
#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/pose.h"
#include "engine/render/look.h"
#include "engine/render/renderer.h"
#include "engine/render/sight.h"

namespace typodont::render {

/// A triangle that hides light and reflects it diffusely; counter-clockwise seen from outside. Its back is black.
struct LitTriangle {
  std::array<glm::vec3, 3> corners;  // m, W
  glm::vec3 albedo{0.5f};            // linear
};

/// Adds the triangles of a body's bricks; `origin`: m, W, origin of the vertices.
void append_triangles(std::vector<LitTriangle>& triangles, std::span<const MeshUpdate> bricks, const dvec3& origin,
                      const std::array<Look, kMatterCount>& looks);

/// What lights a scene from outside.
struct LightSources {
  std::function<glm::vec3(const glm::vec3& direction)> room;  // linear radiance from a unit direction
  glm::vec3 toward_lamp{0, 0, 1};                             // unit
  float lamp_half_angle = 0;                                  // rad
  glm::vec3 lamp{0};  // radiance that a white surface facing the lamp reflects: irradiance over π
};
/// The sources that the shaders use.
LightSources sources_of(const Lights& lights);

class LightScene {
 public:
  /// Casts rays from the samples of a grid that lie near a triangle. `box`: the grid's bounds, m, W; `spacing`: m. Uses
  /// several threads; equal arguments give equal results.
  LightScene(std::vector<LitTriangle> triangles, const BoxInWorld& box, double spacing);
  ~LightScene();
  LightScene(LightScene&&) noexcept;
  LightScene& operator=(LightScene&&) noexcept;

  /// The light after `bounces` diffuse reflections. Casts rays to the lamp only.
  LightGrid light(const LightSources& sources, int bounces = 4) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The light that reaches a surface at p (m, W) with the normal n, interpolated as the shaders do: see
/// LightGrid::faces.
glm::vec4 light_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n);

}  // namespace typodont::render
