// Light that has travelled inside translucent tissue. Light that enters enamel, dentin or gum is scattered many times
// and leaves the tissue up to a few millimetres away. So shadows and fissures are soft, and ridges are bright. This
// light is computed by random walks on the CPU, in a grid of cells around the working tooth, and the shaders read it
// per vertex. On opaque bodies, the grid contains the light that arrives. It is used only in scenes with a LightGrid.
// When the tissue is cut, only the cells near the cut are computed again.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "engine/render/light_scene.h"
#include "engine/render/renderer.h"

namespace typodont::render {

/// Returns the probability with which a photon survives a scattering event, so that a thick flat layer of isotropically
/// scattering tissue with this diffuse reflectance reflects exactly this fraction of diffuse light. Our own fit to
/// Chandrasekhar's solution (Radiative Transfer, 1950); its relative error is at most 0.4 %.
float scattering_albedo(float reflectance);

/// The light inside the bodies near the working tooth. For one thread at a time; equal calls give equal results.
class TissueLight {
 public:
  /// Makes the grid. `box`: m, frame W, bounds of the grid; `spacing`: m, edge of a cell; `walks`: number of random
  /// walks from each cell beside a surface.
  TissueLight(const BoxInWorld& box, double spacing, int walks, const std::array<Look, kMatterCount>& looks);
  ~TissueLight();
  TissueLight(TissueLight&&) noexcept;
  TissueLight& operator=(TissueLight&&) noexcept;

  /// Adds a static body. `hard`: true for a tooth or another hard body, which may overlap soft bodies. Call it before
  /// light().
  void add_fixed(std::vector<LitTriangle> triangles, bool hard);
  /// Replaces bricks (blocks of triangles) of the working tooth; `origin`: m, frame W, origin of their vertices.
  void put(std::span<const MeshUpdate> bricks, const dvec3& origin);

  /// Computes the light of all cells, on several threads. `far`: the light that arrives from outside the box.
  void light(const LightSources& sources, const LightGrid& far);
  /// Computes the light again in at most `most` of the cells near which put() changed the surface, on the caller's
  /// thread. The next calls compute the others. Returns the box of the grid's changed values.
  CellBox refresh(int most);

  const TissueLightGrid& grid() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::render
