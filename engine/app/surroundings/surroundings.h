// The surroundings of the working tooth: its neighbours and the gum. If a scene requests them ("surroundings"), they
// are built from the tooth's own volume. They are drawn, and a rotating bur that enters them damages them
// (task/damage.h). They do not belong to the haptic field, so the hand does not feel them, and they are never cut.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/surroundings/plan.h"
#include "engine/render/renderer.h"
#include "engine/render/sight.h"

namespace typodont {

struct Surroundings;

/// The surroundings as distance functions, m, negative inside. The functions are exact only near a body: far away from
/// a body, or if it does not exist, they return any positive number. Thread-safe.
class SurroundingsShape {
 public:
  /// Builds the distance functions. Throws Error if the volume cannot be read.
  explicit SurroundingsShape(const SurroundingsPlan& plan);
  ~SurroundingsShape();
  SurroundingsShape(SurroundingsShape&&) noexcept;
  SurroundingsShape& operator=(SurroundingsShape&&) noexcept;

  bool has_neighbours() const;
  bool has_gum() const;
  double neighbour(const dvec3& p_W) const;  // returns the distance (m) to the nearest neighbouring tooth
  double gum(const dvec3& p_W) const;
  double tooth(const dvec3& p_W) const;  // returns the distance (m) to the uncut working tooth
  // Returns the distance (m) to a solid that consists of the rubber dam's sheet and everything below it.
  double dam(const dvec3& p_W) const;
  double clamp(const dvec3& p_W) const;  // returns the distance (m) to the clamp of the rubber dam
  // Returns the distance (m) to tongue, cheeks and lips, or to the mask of a phantom head.
  double mouth(const dvec3& p_W) const;

  /// Makes the face of a section through the neighbouring teeth with their roots, and through the gum around them. It
  /// corresponds to section_face() for the working tooth. Positions are relative to `origin` (m, frame W).
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
  /// A plane. On one side of it, at points p_W with dot(covered, (p_W, 1)) < 0, the gum hides the uncut tooth. Zero:
  /// the gum hides no point.
  glm::dvec4 covered{0};
  double coarse_from = 0;  // m; the coarse mesh is used if the picture allows a surface error larger than this
  /// The region in which the light that bodies receive from each other is computed (render::LightScene). Empty if the
  /// scene has no mouth.
  std::optional<render::BoxInWorld> lit;
};
/// Builds the meshes of the surroundings. Equal plans give equal meshes. Throws Error if the volume cannot be read.
Surroundings make_surroundings(const SurroundingsPlan& plan);
/// Reads the meshes of a scene's surroundings from the cache, or builds them. Empty if the scene has none.
Surroundings make_surroundings(const std::optional<SurroundingsPlan>& plan);
std::optional<SurroundingsShape> surroundings_shape(const std::optional<SurroundingsPlan>& plan);
/// Returns the surroundings as distance functions, for damage and for hands that avoid them. Empty if the scene has
/// none, or if they are not monitored.
std::optional<SurroundingsShape> monitored_shape(const std::optional<SurroundingsPlan>& plan);

}  // namespace typodont
