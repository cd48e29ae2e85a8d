// Light that surfaces receive from the room and from each other. It is computed once for static bodies by casting rays
// on the CPU, and stored in a grid that the shaders sample (shaders/lighting.glsl). The grid does not include light
// that comes directly from the lamp.
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

/// Returns the light that a smooth surface, or the film of saliva on it, mirrors onto other bodies. `film`: fraction of
/// diffuse light that the surface mirrors; `lamp`: light that arrives directly from the lamp; `diffuse`: all other
/// light that arrives. The surface mirrors the lamp's light into a single direction, which often leads out of the
/// mouth. kLampKept is the fraction of the mirrored light of the lamp that reaches other bodies. We chose its value by
/// comparison with the reference pictures (tests/reference): with this value, cheek and skin have the same brightness.
inline glm::vec3 mirrored_by_film(float film, const glm::vec3& lamp, const glm::vec3& diffuse) {
  constexpr float kLampKept = 0.5f;
  return film * (kLampKept * lamp + diffuse);
}

/// A triangle that blocks light and reflects it diffusely. Its corners are counter-clockwise as seen from outside. Its
/// back is black.
struct LitTriangle {
  std::array<glm::vec3, 3> corners;  // m, frame W, corners of the triangle
  glm::vec3 color{0.5f};             // diffuse reflectance of the tissue, for linear red, green and blue
  // fraction of diffuse light that the surface or its film of saliva reflects before it reaches the tissue
  float film = 0;
  std::array<glm::vec3, 3> normals{};  // unit normals of the surface at the corners
  glm::vec3 free_path{0};              // m, mean free path of light in the tissue, for red, green and blue; 0: opaque
  bool metal = false;

  /// Returns the light that the triangle reflects to other bodies. `lamp`: direct light of the lamp that arrives;
  /// `diffuse`: all other light that arrives.
  glm::vec3 reflected(const glm::vec3& lamp, const glm::vec3& diffuse) const {
    return (1 - film) * color * (lamp + diffuse) + mirrored_by_film(film, lamp, diffuse);
  }
};

/// Adds the triangles of a body's bricks (blocks of triangles); `origin`: m, frame W, origin of the vertices.
void append_triangles(std::vector<LitTriangle>& triangles, std::span<const MeshUpdate> bricks, const dvec3& origin,
                      const std::array<Look, kMatterCount>& looks);

/// The sources of light outside the bodies: the room and the lamp.
struct LightSources {
  /// returns the linear radiance of the room from a unit direction
  std::function<glm::vec3(const glm::vec3& direction)> room;
  glm::vec3 toward_lamp{0, 0, 1};  // unit vector towards the lamp
  float lamp_half_angle = 0;       // rad, half the angle that the lamp subtends
  /// radiance that a white surface facing the lamp reflects: the irradiance divided by π
  glm::vec3 lamp{0};
};
/// Returns the sources of light that the shaders use for `lights`.
LightSources sources_of(const Lights& lights);

class LightScene {
 public:
  /// Casts rays from those samples of a grid that lie near a triangle, or reads their hits from the cache. `box`: m,
  /// frame W, bounds of the grid; `spacing`: m. `tissue_mirrors`: true if the light that surfaces mirror is computed at
  /// each sample beside tissue; false if only beside metal, and elsewhere at every second sample. Uses several threads;
  /// equal arguments give equal results.
  LightScene(std::vector<LitTriangle> triangles, const BoxInWorld& box, double spacing, bool tissue_mirrors = false);
  ~LightScene();
  LightScene(LightScene&&) noexcept;
  LightScene& operator=(LightScene&&) noexcept;

  /// Returns the light after `bounces` diffuse reflections. This call casts rays only to the lamp.
  LightGrid light(const LightSources& sources, int bounces = 8) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Returns the light that reaches a surface at p (m, frame W) with the normal n, interpolated as in the shaders; see
/// LightGrid::faces.
glm::vec4 light_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n);
/// Returns the light from the direction r that a smooth surface with the normal n mirrors at p (m, frame W), as in the
/// shaders.
glm::vec3 mirrored_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n, const glm::vec3& r);
/// Returns the unit direction of a node of LightGrid::images. It is an octahedral map (Engelhardt & Dachsbacher 2008),
/// whose outer nodes lie on the edge of the square.
glm::vec3 image_direction(const glm::ivec2& node);

}  // namespace typodont::render
