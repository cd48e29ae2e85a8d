// The surroundings of the working tooth: its neighbours and the gum. They are built from the tooth's own volume if a
// scene requests them ("surroundings"). They are drawn, and a rotating bur that enters them does damage
// (task/damage.h). They are not part of the haptic field and are never cut.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/surroundings/plan.h"
#include "engine/render/renderer.h"
#include "engine/render/sight.h"

namespace typodont {

struct Surroundings;

/// The surroundings as distance functions, m, negative inside. Far away from a body, or if the body does not exist,
/// the value is any positive number. Thread-safe.
class SurroundingsShape {
 public:
  /// Builds the distance functions. Throws Error if the volume cannot be read.
  explicit SurroundingsShape(const SurroundingsPlan& plan);
  ~SurroundingsShape();
  SurroundingsShape(SurroundingsShape&&) noexcept;
  SurroundingsShape& operator=(SurroundingsShape&&) noexcept;

  bool has_neighbours() const;
  bool has_gum() const;
  double neighbour(const dvec3& p_W) const;  // distance to the nearest neighbour
  double gum(const dvec3& p_W) const;
  double tooth(const dvec3& p_W) const;  // distance to the uncut working tooth
  // distance to the solid that consists of the rubber dam's sheet and everything below it
  double dam(const dvec3& p_W) const;
  double clamp(const dvec3& p_W) const;  // distance to the dam's clamp
  // distance to the tongue, the cheeks and the lips, or to the mask of a phantom head
  double mouth(const dvec3& p_W) const;

  /// The face of a section through the neighbours with their roots and the gum around them, like section_face() for the
  /// tooth. Positions are relative to `origin`, m, W.
  std::vector<render::MeshUpdate> section_face(const dvec3& normal, double offset, const dvec3& origin) const;

 private:
  friend Surroundings make_surroundings(const SurroundingsPlan& plan);
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

struct SurroundingMesh {
  render::MeshId id;
  dvec3 origin;  // m, W, origin of the vertices
  std::vector<render::MeshUpdate> bricks;
  std::vector<render::MeshUpdate> coarse;  // the same body with fewer triangles
};
struct Surroundings {
  std::vector<SurroundingMesh> meshes;
  /// The gum covers the uncut tooth, and makes it invisible, at points p_W with dot(covered, (p_W, 1)) < 0. Zero: at
  /// no point.
  glm::dvec4 covered{0};
  double coarse_from = 0;  // m, threshold: the coarse mesh is sufficient if the allowed surface error is larger
  /// The region in which light between bodies is computed (render::LightScene). Empty: a scene without a mouth.
  std::optional<render::BoxInWorld> lit;
};
/// Builds the meshes. Equal plans give equal meshes. Throws Error if the volume cannot be read.
Surroundings make_surroundings(const SurroundingsPlan& plan);
/// The surroundings for a scene (Scene::surroundings); empty if the scene has none.
Surroundings make_surroundings(const std::optional<SurroundingsPlan>& plan);
std::optional<SurroundingsShape> surroundings_shape(const std::optional<SurroundingsPlan>& plan);
/// The shape for damage, and for hands that avoid the surroundings. Empty also if the scene's surroundings are not
/// monitored.
std::optional<SurroundingsShape> monitored_shape(const std::optional<SurroundingsPlan>& plan);

}  // namespace typodont
