// Light that comes from the room and from other surfaces, without the lamp's direct light. Rays are traced once for
// static bodies, by the CPU or a graphics card; the result is a grid for shaders/lighting.glsl.
#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/base/pose.h"
#include "engine/render/look.h"
#include "engine/render/renderer.h"
#include "engine/render/sight.h"

namespace typodont::render {

/// Light that a smooth surface or its saliva mirrors onto others. `film`: mirrored fraction of diffuse light. The lamp
/// is mirrored in one direction, often out of the mouth, so only the fraction kLampKept reaches others.
inline glm::vec3 mirrored_by_film(float film, const glm::vec3& lamp, const glm::vec3& diffuse) {
  constexpr float kLampKept = 0.5f;
  return film * (kLampKept * lamp + diffuse);
}

/// A triangle that blocks and diffusely reflects light. Counter-clockwise seen from outside; its back is black.
struct LitTriangle {
  std::array<glm::vec3, 3> corners;  // m, frame W, corners of the triangle
  glm::vec3 color{0.5f};             // diffuse reflectance, linear
  // Fraction of diffuse light that the saliva mirrors before it reaches the tissue.
  float film = 0;
  std::array<glm::vec3, 3> normals{};  // unit normals of the surface at the corners
  glm::vec3 free_path{0};              // m, mean free path of red, green, blue light in the tissue; 0: opaque
  bool metal = false;

  /// Light that the triangle sends to others. `lamp`: direct light that arrives; `diffuse`: other light.
  glm::vec3 reflected(const glm::vec3& lamp, const glm::vec3& diffuse) const {
    return (1 - film) * color * (lamp + diffuse) + mirrored_by_film(film, lamp, diffuse);
  }
};

/// Appends the triangles of bricks. `origin`: origin of the bricks' vertices, m, frame W.
void append_triangles(std::vector<LitTriangle>& triangles, std::span<const MeshUpdate> bricks, const dvec3& origin,
                      const std::array<Look, kMatterCount>& looks);

/// Sources of light: room and lamp.
struct LightSources {
  /// Linear radiance of the room from a unit direction.
  std::function<glm::vec3(const glm::vec3& direction)> room;
  glm::vec3 toward_lamp{0, 0, 1};  // unit vector towards the lamp
  float lamp_half_angle = 0;       // rad, half the angle that the lamp subtends
  /// Irradiance / π of a white surface that faces the lamp.
  glm::vec3 lamp{0};
};
/// Converts a frame's lights to light sources, with the same formulas as the shaders.
LightSources sources_of(const Lights& lights);

class LightPasses;

/// Used by one thread at a time.
class LightScene {
 public:
  /// Casts rays from samples near triangles. `box`, `spacing`: m. `tissue_mirrors`: where mirrored light is computed;
  /// true: at each sample beside tissue; false: at every second sample beside metal. After a request to `stop`, throws
  /// Stopped (engine/base/in_parallel.h). `passes`: compute passes that cast the rays; if there are none or they fail,
  /// the CPU casts them.
  LightScene(std::vector<LitTriangle> triangles, const BoxInWorld& box, double spacing, bool tissue_mirrors = false,
             std::stop_token stop = {}, std::shared_ptr<LightPasses> passes = nullptr);
  ~LightScene();
  LightScene(LightScene&&) noexcept;
  LightScene& operator=(LightScene&&) noexcept;

  /// Light after `bounces` diffuse reflections. Casts new rays only to the lamp.
  LightGrid light(const LightSources& sources, int bounces = 8) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Light at p (m, frame W) on a surface with normal n, interpolated as in the shaders; see LightGrid::faces.
glm::vec4 light_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n);
/// Light from direction r that is mirrored at p (m, frame W), normal n, as in the shaders.
glm::vec3 mirrored_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n, const glm::vec3& r);
/// Direction of a node of LightGrid::images, in an octahedral map (Engelhardt & Dachsbacher 2008) whose outer nodes lie
/// on the edge.
glm::vec3 image_direction(const glm::ivec2& node);

}  // namespace typodont::render
