// Light that scatters in enamel, dentin and gum and leaves them millimetres away. It softens shadows and brightens
// ridges. Computed by random walks in a grid around the working tooth; after a cut, only in cells nearby. The walks run
// on the CPU or, with LightPasses, on a graphics card.
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

class LightPasses;

/// Probability that light survives one scattering, chosen so that a thick flat layer reflects the fraction
/// `reflectance` of diffuse light. Our fit to Chandrasekhar (Radiative Transfer, 1950); relative error up to 0.4 %.
float scattering_albedo(float reflectance);

/// Used by one thread at a time. Equal calls give equal results.
class TissueLight {
 public:
  /// `box`: m, frame W; `spacing`: m; `walks`: random walks per cell beside a surface.
  /// After a request to `stop`, light() and refresh() throw Stopped (engine/base/in_parallel.h).
  TissueLight(const BoxInWorld& box, double spacing, int walks, const std::array<Look, kMatterCount>& looks,
              std::stop_token stop = {});
  ~TissueLight();
  TissueLight(TissueLight&&) noexcept;
  TissueLight& operator=(TissueLight&&) noexcept;

  /// Adds a static body. `hard`: the body may overlap soft bodies. Call before light().
  void add_fixed(std::vector<LitTriangle> triangles, bool hard);
  /// Replaces bricks of the working tooth. `origin`: origin of the bricks' vertices, m, frame W.
  void put(std::span<const MeshUpdate> bricks, const dvec3& origin);

  /// Sets the compute passes that follow rays and walks on a graphics card. Null: the CPU follows them. If the card
  /// fails, the CPU continues. Call before light().
  void use(std::shared_ptr<LightPasses> passes);
  bool on_card() const;

  /// Computes the light of all cells with several threads. `far`: light from outside the box.
  void light(const LightSources& sources, const LightGrid& far);
  /// Computes at most `most` cells near changes by put(), on the caller's thread or the card; later calls do the rest.
  /// Returns the box of changed cells; empty: no cell waits.
  CellBox refresh(int most);

  const TissueLightGrid& grid() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::render
