// Finds the cavities of a body: closed spaces, and spaces with a narrow opening.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Number of a region's outer voxel faces, for each kind of neighbour.
struct Contacts {
  std::size_t mouth = 0, wall = 0, dense = 0, cavity = 0;
};

/// Finds hollows: closed spaces in bone that contain air, or are larger than any marrow space. All other closed spaces
/// are marrow.
class Hollows {
 public:
  /// `air`: grey value below which a space contains air; nullopt if the scale of grey values is unknown. `voxel`: m.
  Hollows(const Sparse<float>& smooth, const std::optional<double>& air, double voxel)
      : smooth_(smooth), air_(air), largest_(kMaxMarrow / (voxel * voxel * voxel)) {}

  /// Returns for each closed space in bone: true if it is a hollow, false if it contains marrow.
  std::vector<bool> operator()(const SparseComponents& spaces) const;

 private:
  // Volume of the largest marrow space, m³; a whole femur contains 100 cm³ of marrow.
  static constexpr double kMaxMarrow = 150e-6;
  const Sparse<float>& smooth_;
  std::optional<double> air_;
  double largest_;
};

/// Finds cavities with a ball of growing radius, up to `widest_mouth` (voxels), which enters from the walls of the box.
/// A pocket that the ball can't enter is a cavity if its opening is small compared to its wall (root canal), otherwise
/// outside (fissure). Hollows of bone are written to `hollow`. Blocks that are not stored and not connected to the
/// walls become inside.
SparseMask find_cavities(const SparseMask& solid, const SparseMask& dense, double widest_mouth, bool tooth,
                         const std::shared_ptr<BlockSet>& set, const Hollows& hollows, SparseMask& hollow);

}  // namespace typodont::haptics::importing
