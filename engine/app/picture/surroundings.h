// What stands around the working tooth: its neighbours and the gum. Made from the tooth's own volume when a scene asks
// for it ("surroundings"). Drawn, and watched: a turning bur that gets into them is damage (damage.h). Not in the
// haptic field, never cut.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/base/json.h"
#include "engine/render/renderer.h"

namespace typodont {

struct Scene;
struct Surroundings;

/// A tooth like the working one, mirrored where the two touch. Metres, W.
struct NeighbourTooth {
  dvec3 contact{0, 0, 0};  // the point where they touch: mirrored in the plane through it, square to the arch
  dvec3 scale{1, 1, 1};    // about the contact
  double turn = 0;         // rad about the crown's axis through the contact
};

struct SurroundingsPlan {
  std::filesystem::path volume;  // whose tooth is copied
  dvec3 crown{0, 0, 1};          // unit, towards the biting side
  dvec3 arch{1, 0, 0};           // unit, along the row of teeth, square to the crown's axis
  std::vector<NeighbourTooth> neighbours;
  bool gum = false;
  dvec3 margin{0, 0, 0};         // the gum's edge on the tooth: a plane through this point …
  dvec3 margin_normal{0, 0, 1};  // … square to this
  double papilla = 2e-3;         // m, how much higher the gum stands between two teeth
  double thickness = 1.1e-3;     // m, of the gum on the root
  double length = 34e-3;         // m, of the piece of jaw
};

/// Reads a scene's "surroundings" (docs/interface.md); `volume` is the scene's own. Throws Error.
SurroundingsPlan read_surroundings(const Json& json, const std::filesystem::path& volume,
                                   const ScenePlace& place);

/// The same as distances, m, negative inside; far away, or where there is none, any positive number. Several threads
/// may ask.
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
/// What the scene wants to stand around its tooth; nothing where it does not say.
Surroundings make_surroundings(const Scene& scene);
std::optional<SurroundingsShape> surroundings_shape(const Scene& scene);

}  // namespace typodont
