// Neighbours and gum ("surroundings" of a scene), from the tooth's own volume: drawn and monitored (task/damage.h),
// neither felt nor cut.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/surroundings/plan.h"
#include "engine/render/renderer.h"
#include "engine/render/sight.h"

namespace typodont {

struct Surroundings;

/// m, negative inside; exact only near a body, else any positive number. Thread-safe.
class SurroundingsShape {
 public:
  /// Throws Error.
  explicit SurroundingsShape(const SurroundingsPlan& plan);
  ~SurroundingsShape();
  SurroundingsShape(SurroundingsShape&&) noexcept;
  SurroundingsShape& operator=(SurroundingsShape&&) noexcept;

  bool has_neighbours() const;
  bool has_gum() const;
  double neighbour(const dvec3& p_W) const;  // returns the distance (m) to the nearest neighbouring tooth
  double gum(const dvec3& p_W) const;
  double tooth(const dvec3& p_W) const;  // returns the distance (m) to the uncut working tooth
  // m to the sheet and all below.
  double dam(const dvec3& p_W) const;
  double clamp(const dvec3& p_W) const;  // returns the distance (m) to the clamp of the rubber dam
  // m to tongue, cheeks and lips, or a phantom's mask.
  double mouth(const dvec3& p_W) const;

  /// Neighbours with roots, and gum; as section_face(). Relative to `origin` (m, W).
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
  std::vector<render::MeshUpdate> coarse;  // coarse meshes of the same body, with fewer triangles
};
struct Surroundings {
  std::vector<SurroundingMesh> meshes;
  /// dot(covered, (p_W, 1)) < 0: uncut tooth hidden by gum; zero: nothing.
  glm::dvec4 covered{0};
  double coarse_from = 0;  // m, surface error from which the coarse mesh is used
  /// light between bodies (render::LightScene); empty: no mouth
  std::optional<render::BoxInWorld> lit;
};
/// Equal plans, equal meshes. Throws Error.
Surroundings make_surroundings(const SurroundingsPlan& plan);
/// Cached or built; empty: none.
Surroundings make_surroundings(const std::optional<SurroundingsPlan>& plan);
std::optional<SurroundingsShape> surroundings_shape(const std::optional<SurroundingsPlan>& plan);
/// For damage and hands that avoid them; empty: none, or not monitored.
std::optional<SurroundingsShape> monitored_shape(const std::optional<SurroundingsPlan>& plan);

}  // namespace typodont
