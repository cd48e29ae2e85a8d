// The surface contact point (SCP): the proxy of the hand's position (haptic interface point, HIP). It stays outside the
// mesh.
#pragma once

#include <array>
#include <span>

#include "haptics/contact/mesh_lod/plane_set.h"
#include "haptics/contact/mesh_lod/surface_contact.h"

namespace typodont::haptics::mesh_lod {

/// The stiffness of each tissue, N/m. Each border from a softer to a stiffer tissue acts as a wall.
using Stiffness = PerTissue;

struct SurfaceOptions {
  double radius = 0;  // m, radius of the tool's end; 0: a point
  // true: borders between tissues have walls, which stop a tool only on its way from the softer to the stiffer tissue
  bool walls = true;
  double wall_limit = 0.5;  // N, force above which a wall yields
  // N/m, stiffness of the coupling (the spring between the contact point and the hand) if the tissue's own stiffness is
  // 1 N/mm; the stiffness of the coupling is proportional to the tissue's own stiffness
  double unit_force = 1000;
};

/// Surface contact point after Wang et al. 2009, section 3.2. The paper's search moves from a primitive (vertex, edge
/// or face) to a neighbour as long as the distance to the HIP decreases. Here, every face near the point adds a plane
/// through its nearest primitive. The point moves to the position nearest to the HIP that satisfies all planes; this is
/// repeated until the point does not move. The result is the same, but the method needs no links between neighbours,
/// which do not exist at cracks, duplicate triangles and slivers. No step can pass through a face of any mesh. The
/// point is the centre of a ball with the tool's radius; a point tool is a ball of radius `kSkin`. Servo thread; never
/// allocates.
class SurfacePoint final : public SurfaceContact {
 public:
  static constexpr double kSkin = 1e-8;        // m, smallest distance of the point from a face
  static constexpr double kFarthest = 1.5e-3;  // m, largest allowed value of the argument `most` of clearance()
  // If follow() has tested this number of faces during contact, it starts no further iteration in this tick. The next
  // call continues.
  static constexpr int kMostTested = 800;

  SurfacePoint(const SurfaceOptions& options, const Stiffness& stiffness) : options_(options), stiffness_(stiffness) {}

  double radius() const noexcept override { return options_.radius > kSkin ? options_.radius : kSkin; }
  double reach() const noexcept override { return radius(); }
  double outlook() const noexcept override { return radius() + kFarthest; }

  /// Starts a contact with the ball's centre at p. If p is inside the tissue, or nearer to it than the ball's radius,
  /// moves the ball out and returns false.
  bool put(const TriangleGrid& grid, const dvec3& p) noexcept override;
  void put_free(const dvec3& p) noexcept override;
  void map_to(const TriangleGrid& grid) noexcept override;
  void follow(const TriangleGrid& grid, const dvec3& hip, bool give = false) noexcept override;
  void mesh_changed() noexcept override { collected_ = nullptr; }
  double clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept override;
  bool is_free(const TriangleGrid& grid, const Pose& X_W) const noexcept override {
    return !grid.nearest(X_W.p, radius()).found;
  }
  PerTissue engaged_area(const TriangleGrid& grid, const dvec3& way) noexcept override;

 private:
  bool lift(const TriangleGrid& grid, dvec3 n) noexcept;
  void collect(const TriangleGrid& grid, double reach) noexcept;
  void round_edge(const TriangleGrid& grid, const dvec3& hip, const Plane& plane, dvec3& step) const noexcept;
  bool rests_on(const TriangleGrid& grid, Plane& plane) const noexcept;
  bool look(const TriangleGrid& grid, double reach, bool give) noexcept;
  std::span<const std::uint32_t> close_faces(const TriangleGrid& grid, double within) noexcept;
  void add_walls(const Face& face, std::uint32_t index, std::uint64_t order, double reach, bool& room) noexcept;
  double stiffness_of(Tissue tissue) const noexcept { return stiffness_[static_cast<std::size_t>(tissue)]; }

  SurfaceOptions options_;
  Stiffness stiffness_;
  Tissue ground_ = Tissue::kAir;  // tissue in contact; kAir: no contact
  // true after a wall has yielded: all walls are ignored until the contact is on the harder tissue `beyond_`
  bool behind_ = false;
  Tissue beyond_ = Tissue::kAir;  // the harder tissue of the wall that yielded
  // Indices and bounding boxes of the collected faces, with one array per coordinate. kMostNear: largest number of
  // collected faces; kBatch: number of faces that one vector instruction tests.
  static constexpr int kMostNear = 4096, kBatch = 8;
  struct Boxes {
    alignas(32) float lo_x[kMostNear + kBatch], lo_y[kMostNear + kBatch], lo_z[kMostNear + kBatch];
    alignas(32) float hi_x[kMostNear + kBatch], hi_y[kMostNear + kBatch], hi_z[kMostNear + kBatch];
  };
  std::array<std::uint32_t, kMostNear> near_{};
  int near_count_ = 0;
  Boxes boxes_{};
  // grid from which the faces were collected; null: they must be collected again
  const TriangleGrid* collected_ = nullptr;
  // The faces that the present iteration uses, as indices into near_.
  std::array<std::uint32_t, kMostNear + kBatch> close_{};
  dvec3 near_from_{0};
  double near_reach_ = 0;
  // A face whose nearest primitive is an edge or a corner.
  struct Edge {
    std::uint32_t face = 0, near = 0;  // near: index of the face in near_
    OnFace at;
    dvec3 n{0};           // unit vector from the nearest point to the ball's centre
    double distance = 0;  // m, distance of the nearest point from the ball's centre
  };
  // The rank of a plane is its face's index in near_, with one of these bits, so that planes of edges follow all planes
  // of interiors, and walls follow all planes of edges.
  static constexpr std::uint64_t kOfEdge = std::uint64_t{1} << 62, kOfWall = std::uint64_t{1} << 63;
  std::array<Edge, kMostNear> edges_;
  PlaneSet planes_;
  // Planes of the faces to whose interior the ball is nearest; they are first in the list of planes. There is one array
  // for each coordinate of the normal, and one for the plane's distance from the ball's centre.
  struct Inner {
    alignas(32) float x[PlaneSet::kMost], y[PlaneSet::kMost], z[PlaneSet::kMost], distance[PlaneSet::kMost];
  };
  Inner inner_{};
  static constexpr std::uint32_t kNoPlane = ~0U;
  /// Hash table that maps a face to its plane in inner_.
  class PlaneOfFace {
   public:
    void clear() noexcept {
      if (++time_ == 0) slots_.fill({}), time_ = 1;
    }
    void add(std::uint32_t face, std::uint32_t plane) noexcept {
      std::size_t at = start(face);
      while (slots_[at].time == time_) at = (at + 1) % kSlots;
      slots_[at] = {time_, face, plane};
    }
    /// Returns the index in inner_ of the plane of a face; kNoPlane if the face has no plane there.
    std::uint32_t find(std::uint32_t face) const noexcept {
      std::size_t at = start(face);
      for (; slots_[at].time == time_; at = (at + 1) % kSlots) {
        if (slots_[at].face == face) return slots_[at].plane;
      }
      return kNoPlane;
    }

   private:
    struct Slot {
      // time: value of time_ when the entry was added; clear() increases time_, so older entries do not count
      std::uint32_t time = 0, face = 0, plane = 0;
    };
    static constexpr int kBits = 13;
    static constexpr std::size_t kSlots = 1 << kBits;
    static_assert(kSlots >= 4 * PlaneSet::kMost);
    static std::size_t start(std::uint32_t face) noexcept { return face * 0x9e3779b1U >> (32 - kBits); }
    std::array<Slot, kSlots> slots_{};
    std::uint32_t time_ = 0;
  };
  PlaneOfFace inner_of_;
  std::array<std::uint32_t, PlaneSet::kMost> above_{};
  // effort of this call of follow(): the number of tested faces, plus a quarter (1 / kCollectedPerTest) of the number
  // of collected faces
  int tested_ = 0;
};

}  // namespace typodont::haptics::mesh_lod
