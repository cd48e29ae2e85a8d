// The picture of the soft gum: shows blood, and displaces the gum's vertices where an instrument presses or a bur has
// cut. Only changed mesh bricks are computed again, so a gum at rest takes no time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/app/event_logs.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/render/renderer.h"
#include "haptics/soft_tissue.h"

namespace typodont {

/// Draws the soft gum in one picture. Render thread only.
class SoftGumView {
 public:
  /// A mesh brick of the gum in its current shape, from the fine or the coarse mesh of the surroundings.
  struct Brick {
    render::MeshId mesh = 0;
    bool coarse = false;
    render::MeshUpdate now;
    // Value of version() when this mesh brick last changed. 0: it is still the brick of the undeformed gum.
    std::uint64_t version = 0;
  };

  SoftGumView(std::shared_ptr<const haptics::SoftSurface> surface, const Surroundings& around);

  /// Sets the new state of one point of the gum.
  void move(const haptics::SoftMove& move);
  void bleed(const haptics::SoftWound& wound) { wounds_.push_back({wound, 0}); }
  /// Applies moved points and wounds; other events change nothing.
  void apply(const ServoEvent& event);
  /// Restores the state of an undamaged and undeformed gum.
  void reset();
  /// Computes the changed mesh bricks. `t`: session time, ns.
  void follow(Nanos t);

  std::span<const Brick> bricks() const { return bricks_; }
  /// A number that increases whenever a mesh brick changes.
  std::uint64_t version() const { return version_; }

 private:
  /// Influence of one point of the gum on one vertex.
  struct Influence {
    std::uint32_t point = 0;
    float part = 0;      // 0..1, weight with which the point's displacement moves the vertex
    glm::vec3 slope{0};  // 1/m, gradient of `part` with respect to the vertex's position
  };
  /// The undeformed form of a mesh brick, with triangles that are small enough to show a dent.
  struct Rest {
    const render::MeshUpdate* whole = nullptr;  // this mesh brick as it is in the surroundings, with larger triangles
    dvec3 origin{0};                            // m, frame W, origin of the vertices
    render::MeshUpdate mesh;
    /// For each vertex: index of its first influence. One more entry marks the end of the last vertex.
    std::vector<std::uint32_t> first;
    std::vector<Influence> influences;
    dvec3 middle{0};
    double radius = 0;  // m, radius of the mesh brick's bounding ball around `middle`
    bool changed = false;
  };
  struct Wound {
    haptics::SoftWound place;
    double drawn = 0;  // m, radius of the blood patch in the current picture
  };

  void add_brick(const SurroundingMesh& mesh, const render::MeshUpdate& whole, bool coarse);
  void mark(std::uint32_t brick);
  void make(std::size_t brick);
  float blood_at(const dvec3& p_W) const;

  std::shared_ptr<const haptics::SoftSurface> surface_;
  std::vector<Brick> bricks_;
  std::vector<Rest> rest_;                             // undeformed form of each mesh brick, ordered as bricks_
  std::vector<std::vector<std::uint32_t>> bricks_of_;  // indices of the mesh bricks that each point influences
  std::vector<float> inward_;                          // m, depth to which each point is pressed inward
  std::vector<std::uint32_t> changed_;                 // indices of the mesh bricks that must be computed again
  std::vector<Wound> wounds_;
  std::uint64_t version_ = 0;
};

}  // namespace typodont
