// Cavities of a body: closed, or with a narrow opening.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {

/// Voxel faces of a part by kind of neighbour.
struct Contacts {
  std::size_t mouth = 0, wall = 0, dense = 0, cavity = 0;
};

/// Closed spaces in bone that hold air or exceed any marrow; all others are marrow.
class Hollows {
 public:
  /// `air`: darker is air; empty: unknown scale. `voxel`: m.
  Hollows(const Sparse<float>& smooth, const std::optional<double>& air, double voxel)
      : smooth_(smooth), air_(air), largest_(kLargestMarrow / (voxel * voxel * voxel)) {}

  /// One entry per space: a hollow.
  std::vector<bool> operator()(const SparseComponents& spaces) const;

 private:
  // m³; a whole femur has 100 cm³ of marrow
  static constexpr double kLargestMarrow = 150e-6;
  const Sparse<float>& smooth_;
  std::optional<double> air_;
  double largest_;
};

/// A ball of growing radius, up to `widest_mouth` (voxels), enters from the walls. A pocket that it cannot enter is a
/// cavity if its mouth is small against its wall (root canal), else outside (fissure). Hollows of bone go to `hollow`.
/// Blocks not stored and not connected to the walls become inside.
SparseMask find_cavities(const SparseMask& solid, const SparseMask& dense, double widest_mouth, bool tooth,
                         const std::shared_ptr<BlockSet>& set, const Hollows& hollows, SparseMask& hollow);

}  // namespace typodont::haptics::importing
