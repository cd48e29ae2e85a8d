// The mesh's tolerance follows a pixel's size at the tissue: smaller details need no mesh.
#pragma once

#include "engine/display/display_rig.h"
#include "engine/render/quality.h"

namespace typodont {

/// m, in an eye's picture on this rig's screen.
double screen_pixel(const display::DisplayRig& rig);

/// Voxels, for pixels of `pixel` (m); limited, so that shapes stay.
float surface_tolerance(double pixel, double voxel, const render::Quality& quality);
/// Voxels, from this rig's screen, before the first picture.
float surface_tolerance(const display::DisplayRig& rig, double voxel,
                        const render::Quality& quality = render::kQualityLadder.front());

/// In steps, so that small motions of the head change nothing. Render thread only.
class Detail {
 public:
  Detail(float tolerance, double voxel) : tolerance_(tolerance), voxel_(voxel) {}
  /// `pixel`: render::FrameStats::pixel, m; 0: unknown. True: the tolerance changed.
  bool follow(double pixel, const render::Quality& quality);
  float tolerance() const { return tolerance_; }  // returns the tolerance of the mesh, voxels

 private:
  float tolerance_;
  double voxel_;  // m, voxel size of the tissue
};

}  // namespace typodont
