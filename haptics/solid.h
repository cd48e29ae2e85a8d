// Analytic solids: tissue for tests, teaching and benchmarks, with exact distances.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/base/json.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics {

/// A closed shape with its signed distance, negative inside. Metres, frame W.
class Solid {
 public:
  virtual ~Solid() = default;
  virtual double distance(const dvec3& p_W) const = 0;
  /// Bounds; infinite for unbounded solids.
  virtual void bounds(dvec3& lo, dvec3& hi) const = 0;
  /// True when `distance` is the true distance outside too; max of two distances (a difference) is not.
  virtual bool exact_outside() const { return true; }
};

/// Reads one of: sphere, halfspace, box, cylinder, capsule, torus, union, intersection, difference. Throws Error.
std::unique_ptr<Solid> read_solid(const Json& json);

/// The "tissue" object of a scene with "solids": samples them on voxels. Later solids overwrite the label of earlier
/// ones where they overlap. Throws Error, also when the volume would not fit into memory.
DenseTissue read_solids(const Json& json);

}  // namespace typodont::haptics
