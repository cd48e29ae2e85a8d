// The surface contact point (SCP): a proxy of the hand's position (haptic interface point, HIP) that stays outside the
// mesh.
#pragma once

#include <array>
#include <span>

#include "haptics/contact/mesh_lod/plane_set.h"
#include "haptics/contact/mesh_lod/surface_contact.h"

namespace typodont::haptics::mesh_lod {

/// Stiffness of each tissue, N/m. A border from a softer to a stiffer tissue acts as a wall.
using Stiffness = PerTissue;

struct SurfaceOptions {
  double radius = 0;  // m, radius of the tool's end; 0: a point
  // true: at borders between tissues, walls stop a tool on its way from the softer to the stiffer tissue
  bool walls = true;
  double wall_limit = 0.5;  // N, force above which a wall lets the ball through
  // N/m, stiffness of the coupling for a tissue of 1 N/mm; for other tissues, it is proportional to their stiffness
  double unit_force = 1000;
};

/// Surface contact point (Wang et al. 2009, section 3.2): a ball that moves as near to the HIP as the planes of near
/// faces allow. The paper searches from a face to its neighbours; this class needs no neighbours. Servo thread only;
/// never allocates.
class SurfacePoint final : public SurfaceContact {
 public:
  static constexpr double kSkin = 1e-8;        // m, smallest distance of the point from a face
  static constexpr double kFarthest = 1.5e-3;  // m, upper limit of the argument `most` of clearance()
  // In contact, follow() starts no further iteration after this number of tested faces; the next call continues.
  static constexpr int kMaxTested = 800;

  SurfacePoint(const SurfaceOptions& options, const Stiffness& stiffness) : options_(options), stiffness_(stiffness) {}

  double radius() const noexcept override { return options_.radius > kSkin ? options_.radius : kSkin; }
  double reach() const noexcept override { return radius(); }
  double outlook() const noexcept override { return radius() + kFarthest; }

  /// Starts a contact with the ball's centre at p. If the ball overlaps tissue, moves the ball out and returns false.
  bool put(const TriangleGrid& grid, const dvec3& p) noexcept override;
  void put_free(const dvec3& p) noexcept override;
  void map_to(const TriangleGrid& grid) noexcept override;
  void follow(const TriangleGrid& grid, const dvec3& hip, bool give = false) noexcept override;
  void mesh_changed() noexcept override { collected_ = nullptr; }
  double clearance(const TriangleGrid& grid, const dvec3& p, double most) noexcept override;
  bool is_free(const TriangleGrid& grid, const Pose& X_W) const noexcept override {
    return !grid.nearest(X_W.p, radius()).found;
  }
  PerTissue engaged_area(const TriangleGrid& grid, const dvec3& direction) noexcept override;

 private:
  bool lift(const TriangleGrid& grid, dvec3 n) noexcept;
  void collect(const TriangleGrid& grid, double reach) noexcept;
  void round_edge(const TriangleGrid& grid, const dvec3& hip, const Plane& plane, dvec3& step) const noexcept;
  bool rests_on(const TriangleGrid& grid, Plane& plane) const noexcept;
  bool collect_planes(const TriangleGrid& grid, double reach, bool give) noexcept;
  std::span<const std::uint32_t> close_faces(const TriangleGrid& grid, double within) noexcept;
  void add_walls(const Face& face, std::uint32_t index, std::uint64_t order, double reach, bool& fits) noexcept;
  double stiffness_of(Tissue tissue) const noexcept { return stiffness_[static_cast<std::size_t>(tissue)]; }

  SurfaceOptions options_;
  Stiffness stiffness_;
  Tissue ground_ = Tissue::kAir;  // tissue in contact; kAir: no contact
  // true: a wall has let the ball through, and walls are ignored until the contact is on the harder tissue `beyond_`
  bool behind_ = false;
  Tissue beyond_ = Tissue::kAir;  // harder tissue behind the wall that let the ball through
  // Bounding boxes of the collected faces. kMaxNear: largest number of faces; kBatch: faces per vector instruction.
  static constexpr int kMaxNear = 4096, kBatch = 8;
  struct Boxes {
    alignas(32) float lo_x[kMaxNear + kBatch], lo_y[kMaxNear + kBatch], lo_z[kMaxNear + kBatch];
    alignas(32) float hi_x[kMaxNear + kBatch], hi_y[kMaxNear + kBatch], hi_z[kMaxNear + kBatch];
  };
  std::array<std::uint32_t, kMaxNear> near_{};
  int near_count_ = 0;
  Boxes boxes_{};
  // grid of the collected faces; null: collect again
  const TriangleGrid* collected_ = nullptr;
  // Faces near the ball in the current iteration, as indices into near_.
  std::array<std::uint32_t, kMaxNear + kBatch> close_{};
  dvec3 near_from_{0};
  double near_reach_ = 0;
  // A face whose nearest point is on an edge or corner.
  struct Edge {
    std::uint32_t face = 0, near = 0;  // near: index of the face in near_
    OnFace at;
    dvec3 n{0};           // unit vector from the nearest point to the ball's centre
    double distance = 0;  // m, distance from the nearest point to the ball's centre
  };
  // The order of a plane is its face's index in near_, plus one of these two bits: planes of edges thus follow planes
  // of interiors, and walls come last.
  static constexpr std::uint64_t kOfEdge = std::uint64_t{1} << 62, kOfWall = std::uint64_t{1} << 63;
  std::array<Edge, kMaxNear> edges_;
  PlaneSet planes_;
  // Planes of faces in whose interior the face's point nearest to the ball lies; these planes come first in planes_.
  // Components of the unit normals, and distances from the ball's centre (m).
  struct Inner {
    alignas(32) float x[PlaneSet::kMost], y[PlaneSet::kMost], z[PlaneSet::kMost], distance[PlaneSet::kMost];
  };
  Inner inner_{};
  static constexpr std::uint32_t kNoPlane = ~0U;
  /// Hash table from a face to its plane in inner_.
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
    /// Index of the face's plane in inner_; kNoPlane: none.
    std::uint32_t find(std::uint32_t face) const noexcept {
      std::size_t at = start(face);
      for (; slots_[at].time == time_; at = (at + 1) % kSlots) {
        if (slots_[at].face == face) return slots_[at].plane;
      }
      return kNoPlane;
    }

   private:
    struct Slot {
      // value of time_ when the entry was added; clear() increases time_, so older entries are not valid
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
  // effort of this follow(): tested faces + collected faces / kCollectedPerTest
  int tested_ = 0;
};

}  // namespace typodont::haptics::mesh_lod
