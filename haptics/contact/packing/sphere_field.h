// The distance field of a packing that was cut. Carver thread.
#pragma once

#include <vector>

#include "haptics/contact/packing/sphere_tissue.h"
#include "haptics/tissue_volume.h"

namespace typodont::haptics::packing {

/// Where spheres were cut, the surface runs between what is left of them and what is gone: each point in a gap belongs
/// to the nearer of both. Where none was cut, the field is the tissue's own.
class SphereField {
 public:
  SphereField(const SpherePacking& packing, const SphereTissue& spheres, const SphereTree& original,
              const TissueVolume& untouched)
      : packing_(packing), spheres_(spheres), original_(original), untouched_(untouched), near_(packing.size()) {}

  /// A block of samples as TissueVolume::replace() takes them.
  RasterBlock samples(const glm::ivec3& lo, const glm::ivec3& size);

  static constexpr double kMargin = 7;  // voxels around a sphere that changed; half of that is the field's own reach

 private:
  const SpherePacking& packing_;
  const SphereTissue& spheres_;
  const SphereTree& original_;
  const TissueVolume& untouched_;
  std::vector<int> near_;
};

}  // namespace typodont::haptics::packing
