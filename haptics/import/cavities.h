// Finds the cavities of a body: spaces without a connection to the outside, or with only a narrow opening.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// The contacts of a part with its surroundings: for each kind of neighbour, the number of the part's voxel faces that
/// have a voxel of this kind on their other side.
struct Contacts {
  std::size_t mouth = 0, wall = 0, dense = 0, cavity = 0;
};

/// Decides which closed spaces in a bone are hollows. A hollow is a space that contains air, or a space that is larger
/// than the marrow space of any bone. All other closed spaces are marrow.
class Hollows {
 public:
  /// `air`: a space with a lower grey value contains air; no value if the scale of the grey values is unknown. `voxel`
  /// is in m.
  Hollows(const Sparse<float>& smooth, const std::optional<double>& air, double voxel)
      : smooth_(smooth), air_(air), largest_(kLargestMarrow / (voxel * voxel * voxel)) {}

  /// The result has one entry for each space: true if it is a hollow.
  std::vector<bool> operator()(const SparseComponents& spaces) const;

 private:
  // m³; a space larger than this is a hollow, because the marrow of a whole femur has only about 100 cm³
  static constexpr double kLargestMarrow = 150e-6;
  const Sparse<float>& smooth_;
  std::optional<double> air_;
  double largest_;
};

/// Finds the cavities of the solid: spaces without a connection to the outside, or with only a narrow opening (mouth).
/// A closed space in bone that contains air or is larger than any marrow space (the maxillary sinus, the inside of the
/// skull) is not returned as a cavity but in `hollow`, so it does not become bone.
/// Narrow mouths are found with a ball that moves from the walls of the box into all spaces in which it fits. The
/// radius of the ball increases step by step up to `widest_mouth` (voxels). A pocket is a space that the ball cannot
/// enter. If the area of its mouth is small compared with that of its wall, the pocket is a cavity (a root canal).
/// Otherwise the pocket belongs to the outside (a fissure, the gap between two roots). The function also marks blocks
/// of `set` that are not stored as inside, if they are not connected to the walls.
SparseMask find_cavities(const SparseMask& solid, const SparseMask& dense, double widest_mouth, bool tooth,
                         const std::shared_ptr<BlockSet>& set, const Hollows& hollows, SparseMask& hollow);

}  // namespace typodont::haptics::importing
