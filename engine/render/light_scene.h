// Light of the room and between surfaces, without the lamp's direct light: rays on the CPU once for static bodies, in a
// grid for shaders/lighting.glsl.
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

/// What a smooth surface or its saliva mirrors onto others. `film`: mirrored fraction of diffuse light; `lamp`: direct;
/// `diffuse`: the rest. The lamp is mirrored in one direction, often out of the mouth: kLampKept of it reaches others,
/// chosen by the reference pictures (tests/reference), so that cheek and skin match.
inline glm::vec3 mirrored_by_film(float film, const glm::vec3& lamp, const glm::vec3& diffuse) {
  constexpr float kLampKept = 0.5f;
  return film * (kLampKept * lamp + diffuse);
}

/// Blocks and reflects diffusely. Counter-clockwise from outside; black at the back.
struct LitTriangle {
  std::array<glm::vec3, 3> corners;  // m, frame W, corners of the triangle
  glm::vec3 color{0.5f};             // diffuse reflectance, linear
  // of diffuse light, reflected before it reaches the tissue
  float film = 0;
  std::array<glm::vec3, 3> normals{};  // unit normals of the surface at the corners
  glm::vec3 free_path{0};              // m, red, green, blue; 0: opaque
  bool metal = false;

  /// To others. `lamp`: direct light; `diffuse`: the rest.
  glm::vec3 reflected(const glm::vec3& lamp, const glm::vec3& diffuse) const {
    return (1 - film) * color * (lamp + diffuse) + mirrored_by_film(film, lamp, diffuse);
  }
};

/// `origin`: m, W, of the vertices.
void append_triangles(std::vector<LitTriangle>& triangles, std::span<const MeshUpdate> bricks, const dvec3& origin,
                      const std::array<Look, kMatterCount>& looks);

/// Room and lamp.
struct LightSources {
  /// linear radiance from a unit direction
  std::function<glm::vec3(const glm::vec3& direction)> room;
  glm::vec3 toward_lamp{0, 0, 1};  // unit vector towards the lamp
  float lamp_half_angle = 0;       // rad, half the angle that the lamp subtends
  /// irradiance / π, of a white surface facing the lamp
  glm::vec3 lamp{0};
};
/// As in the shaders.
LightSources sources_of(const Lights& lights);

class LightScene {
 public:
  /// Rays from samples near triangles, or from the cache. `box`: m, W; `spacing`: m. `tissue_mirrors`: mirrored light
  /// at each sample beside tissue, otherwise beside metal and at every second sample. Several threads; equal arguments,
  /// equal results. After a request to `stop`, this and light() throw Stopped (engine/base/in_parallel.h).
  LightScene(std::vector<LitTriangle> triangles, const BoxInWorld& box, double spacing, bool tissue_mirrors = false,
             std::stop_token stop = {});
  ~LightScene();
  LightScene(LightScene&&) noexcept;
  LightScene& operator=(LightScene&&) noexcept;

  /// After `bounces` diffuse reflections. Rays to the lamp only.
  LightGrid light(const LightSources& sources, int bounces = 8) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// At p (m, W) with normal n, interpolated as in the shaders; see LightGrid::faces.
glm::vec4 light_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n);
/// From direction r, mirrored at p (m, W) with normal n, as in the shaders.
glm::vec3 mirrored_at(const LightGrid& grid, const dvec3& p, const glm::vec3& n, const glm::vec3& r);
/// Of a node of LightGrid::images: octahedral map (Engelhardt & Dachsbacher 2008), outer nodes on the edge.
glm::vec3 image_direction(const glm::ivec2& node);

}  // namespace typodont::render
