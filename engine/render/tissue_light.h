// Light scatters in enamel, dentin and gum and leaves millimetres away: soft shadows and fissures, bright ridges.
// Random walks on the CPU in a grid around the working tooth, read per vertex; on opaque bodies, the arriving light.
// Only with a LightGrid. After a cut, only cells nearby are computed again.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/render/light_scene.h"
#include "engine/render/renderer.h"

namespace typodont::render {

/// Survival per scattering, so that a thick flat layer reflects this fraction of diffuse light. Our fit to
/// Chandrasekhar (Radiative Transfer, 1950), relative error up to 0.4 %.
float scattering_albedo(float reflectance);

/// One thread at a time; equal calls, equal results.
class TissueLight {
 public:
  /// `box`: m, W; `spacing`: m; `walks`: per cell beside a surface. After a request to `stop`, light() throws Stopped
  /// (engine/base/in_parallel.h).
  TissueLight(const BoxInWorld& box, double spacing, int walks, const std::array<Look, kMatterCount>& looks,
              std::stop_token stop = {});
  ~TissueLight();
  TissueLight(TissueLight&&) noexcept;
  TissueLight& operator=(TissueLight&&) noexcept;

  /// `hard`: may overlap soft bodies. Before light().
  void add_fixed(std::vector<LitTriangle> triangles, bool hard);
  /// Of the working tooth; `origin`: m, W.
  void put(std::span<const MeshUpdate> bricks, const dvec3& origin);

  /// All cells, several threads. `far`: from outside the box.
  void light(const LightSources& sources, const LightGrid& far);
  /// At most `most` cells near put() changes, on the caller's thread; the rest later. Returns the changed box.
  CellBox refresh(int most);

  const TissueLightGrid& grid() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::render
