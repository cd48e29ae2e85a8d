// What stands around the working tooth: its neighbours and the gum, made from the tooth's own volume where a scene asks
// for it ("surroundings"). They are drawn, and a turning bur that gets into them does damage (task/damage.h). They are
// not in the haptic field and are never cut.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/surroundings/plan.h"
#include "engine/render/renderer.h"

namespace typodont {

struct Surroundings;

/// The surroundings as distances, m, negative inside; far away, or where there is none, any positive number. Several
/// threads may ask.
class SurroundingsShape {
 public:
  /// Throws Error when the volume cannot be read.
  explicit SurroundingsShape(const SurroundingsPlan& plan);
  ~SurroundingsShape();
  SurroundingsShape(SurroundingsShape&&) noexcept;
  SurroundingsShape& operator=(SurroundingsShape&&) noexcept;

  bool has_neighbours() const;
  bool has_gum() const;
  double neighbour(const dvec3& p_W) const;  // the nearest of them
  double gum(const dvec3& p_W) const;
  double tooth(const dvec3& p_W) const;  // the uncut working tooth

  /// The face that a plane cuts through them (as section_face of the tooth): the neighbours with their roots, the gum
  /// around all. Positions relative to `origin`, m, W.
  std::vector<render::MeshUpdate> section_face(const dvec3& normal, double offset, const dvec3& origin) const;

 private:
  friend Surroundings make_surroundings(const SurroundingsPlan& plan);
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

struct SurroundingMesh {
  render::MeshId id;
  dvec3 origin;  // m, W, of its vertices
  std::vector<render::MeshUpdate> bricks;
  std::vector<render::MeshUpdate> coarse;  // the same with fewer triangles
};
struct Surroundings {
  std::vector<SurroundingMesh> meshes;
  /// The uncut tooth lies within the gum where dot(covered, (p_W, 1)) < 0: nobody sees it there. Zero: nowhere.
  glm::dvec4 covered{0};
  double coarse_from = 0;  // m that triangles may be off the surface: from then on the coarse ones will do
};
/// Deterministic. Throws Error when the volume cannot be read.
Surroundings make_surroundings(const SurroundingsPlan& plan);
/// What a scene wants to stand around its tooth (Scene::surroundings); nothing where it does not say.
Surroundings make_surroundings(const std::optional<SurroundingsPlan>& plan);
std::optional<SurroundingsShape> surroundings_shape(const std::optional<SurroundingsPlan>& plan);

}  // namespace typodont
