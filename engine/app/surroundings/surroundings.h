// Neighbouring teeth and gum ("surroundings" of a scene), made from the tooth's own volume. They are drawn, and damage
// to them is measured (task/damage.h); they are neither felt nor cut.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/surroundings/plan.h"
#include "engine/render/renderer.h"
#include "engine/render/sight.h"

namespace typodont {

struct Surroundings;

/// Signed distances to the bodies, m, negative inside. Exact only near a body; farther away, only the sign is right.
/// Thread-safe.
class SurroundingsShape {
 public:
  /// Loads the volume and the row of teeth. Throws Error.
  explicit SurroundingsShape(const SurroundingsPlan& plan);
  ~SurroundingsShape();
  SurroundingsShape(SurroundingsShape&&) noexcept;
  SurroundingsShape& operator=(SurroundingsShape&&) noexcept;

  bool has_neighbours() const;
  bool has_gum() const;
  double neighbour(const dvec3& p_W) const;  // the distance (m) to the nearest neighbouring tooth
  double gum(const dvec3& p_W) const;
  double tooth(const dvec3& p_W) const;  // the distance (m) to the uncut working tooth
  // Distance to the rubber dam and everything below it, m.
  double dam(const dvec3& p_W) const;
  double clamp(const dvec3& p_W) const;  // the distance (m) to the clamp of the rubber dam
  // Distance to tongue, cheeks, lips, or a phantom's mask, m.
  double mouth(const dvec3& p_W) const;

  /// Makes the faces at which a plane cuts the neighbours (with roots) and the gum. The part with normal · p > offset
  /// is kept. Positions are relative to `origin` (m, frame W).
  std::vector<render::MeshUpdate> section_face(const dvec3& normal, double offset, const dvec3& origin) const;

 private:
  friend Surroundings make_surroundings(const SurroundingsPlan& plan);
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

struct SurroundingMesh {
  render::MeshId id;
  dvec3 origin;  // m, frame W, origin of the vertices
  std::vector<render::MeshUpdate> bricks;
  std::vector<render::MeshUpdate> coarse;  // coarse meshes of this body, with fewer triangles
};
struct Surroundings {
  std::vector<SurroundingMesh> meshes;
  /// The uncut tooth is hidden by the gum where dot(covered, (p_W, 1)) < 0. Zero: nothing is hidden.
  glm::dvec4 covered{0};
  double coarse_from = 0;  // m; if a picture allows larger surface errors, the coarse mesh is used
  /// Box in which light between bodies is computed (render::LightScene); empty: there is no mouth.
  std::optional<render::BoxInWorld> lit;
};
/// Makes the meshes. Equal plans give equal meshes. Throws Error.
Surroundings make_surroundings(const SurroundingsPlan& plan);
/// Loads the meshes from the cache or makes them. Empty if there is no plan.
Surroundings make_surroundings(const std::optional<SurroundingsPlan>& plan);
std::optional<SurroundingsShape> surroundings_shape(const std::optional<SurroundingsPlan>& plan);
/// The shape with which damage is measured, and which simulated hands avoid. Empty without surroundings, or if damage
/// is not measured.
std::optional<SurroundingsShape> monitored_shape(const std::optional<SurroundingsPlan>& plan);

}  // namespace typodont
