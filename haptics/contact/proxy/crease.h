// Reconstructs the smooth surfaces (sheets) of the tissue that meet at an edge, a rim or a corner.
#pragma once

#include "haptics/contact/tissue_patch.h"

namespace typodont::haptics {

/// One smooth surface of the tissue (sheet), approximated by the torus with the same position, normal and principal
/// curvatures. Exact for planes, balls, cylinders and tori. Lengths in voxels.
struct Sheet {
  dvec3 x{0}, n{0};       // point of the smooth surface (voxels), and the outward normal there
  dvec3 e1{0}, e2{0};     // unit vectors of the principal curvatures
  double k1 = 0, k2 = 0;  // 1/voxel, principal curvatures, positive for a ball of tissue

  /// Second derivatives of the distance: the sum of w[i] × (v[i]·t)² over i, in the direction of a unit vector t.
  struct Bend {
    dvec3 v[2];
    double w[2];
    double along(const dvec3& t) const noexcept {
      const double a = glm::dot(v[0], t), b = glm::dot(v[1], t);
      return w[0] * a * a + w[1] * b * b;
    }
  };
  /// Signed distance of p from the smooth surface in voxels, the gradient of this distance, and its second derivatives.
  double distance(const dvec3& p) const noexcept;
  double distance(const dvec3& p, dvec3& gradient) const noexcept;
  double distance(const dvec3& p, dvec3& gradient, Bend& bend) const noexcept;
};

/// The smooth surfaces (sheets) of a convex edge, rim or corner. The tissue is the intersection of their insides.
struct Crease {
  static constexpr int kMost = 3;
  int count = 0;
  Sheet sheet[kMost];

  /// Largest signed distance of p from the smooth surfaces of the crease, voxels; positive outside the tissue.
  double above(const dvec3& p) const noexcept;
  /// Moves x onto the line where the smooth surfaces (sheets) i and j meet. `n`: receives both normals there. Returns
  /// false if the two do not meet near x.
  bool onto_line(int i, int j, dvec3& x, dvec3 (&n)[2]) const noexcept;
  /// Moves x to the corner where three smooth surfaces meet. Returns false if there is no corner near x.
  bool onto_corner(dvec3& x, dvec3 (&n)[3]) const noexcept;
};

/// The creases that the head touched last; along these, a sliding head needs no new search. Servo thread only.
class KnownCreases {
 public:
  /// Returns a known crease near x (voxels), or null. Fits its smooth surfaces again if they were fitted far from x.
  const Crease* find(const TissuePatch& patch, const dvec3& x) noexcept;
  void add(const dvec3& x, const Crease& crease) noexcept;
  /// The crease of the last contact, near the point place(); null: none.
  const Crease* last() const noexcept { return count_ > 0 ? &known_[0].crease : nullptr; }
  const dvec3& place() const noexcept { return known_[0].x; }
  /// Must be called when the tissue or the head has changed.
  void forget() noexcept { count_ = 0, none_count_ = 0, room_ = 0; }
  /// Stores that a ball with its centre at c may move by `room` voxels before it touches tissue outside the crease.
  void add_room(const dvec3& c, double room) noexcept { center_ = c, room_ = room; }
  /// `part`: fraction of the room.
  bool has_room(const dvec3& c, double part) const noexcept { return glm::length(c - center_) < part * room_; }
  /// Stores that a search near x, in the direction n, has found no crease, so that it is not repeated.
  void add_none(const dvec3& x, const dvec3& n) noexcept;
  bool is_none(const dvec3& x, const dvec3& n) const noexcept;
  // Voxels. Contact point on the crease last(); its displacement in the last tick, if this was the only contact.
  dvec3 touched{0}, slid{0};

 private:
  static constexpr int kMost = 4;
  struct Known {
    dvec3 x{0};  // point near which the crease was found
    Crease crease;
  };
  Known known_[kMost];  // the crease that was used last comes first
  int count_ = 0;
  dvec3 center_{0};
  double room_ = 0;  // voxels that a ball may move from center_ before it touches tissue outside the crease
  static constexpr unsigned kMaxNone = 8;
  struct {
    dvec3 x{0}, n{0};
  } none_[kMaxNone];
  unsigned none_count_ = 0;  // number of calls of add_none(), modulo 2³²; none_ keeps the last kMaxNone
};

/// Returns true if the field bends far more at x than around x, as at a convex edge. Cheap test for find_crease().
bool is_sharp_at(const TissuePatch& patch, const dvec3& x) noexcept;

/// Fits the smooth surfaces that meet near `x`, a surface point within about two voxels of the crease. `n`: unit vector
/// from x to the head. Returns false if the tissue is smooth or concave at x, or if samples contradict the fits.
bool find_crease(const TissuePatch& patch, const dvec3& x, const dvec3& n, Crease& crease) noexcept;

}  // namespace typodont::haptics
