// Adapts the tolerance of the mesh to the size of a pixel at the tissue: smaller details need no mesh.
#pragma once

#include "engine/display/display_rig.h"
#include "engine/render/quality.h"

namespace typodont {

/// Pixel size of an eye's picture on the screen, m.
double screen_pixel(const display::DisplayRig& rig);

/// Tolerance of the mesh for pixels of size `pixel` (m), voxels. Limited, so that coarse pixels do not deform teeth.
float surface_tolerance(double pixel, double voxel, const render::Quality& quality);
/// Tolerance of the mesh for this rig's screen before the first picture, voxels.
float surface_tolerance(const display::DisplayRig& rig, double voxel,
                        const render::Quality& quality = render::kQualityLadder.front());

/// Changes the mesh's tolerance in steps, so that small motions of the user's head change nothing. Render thread only.
class Detail {
 public:
  Detail(float tolerance, double voxel) : tolerance_(tolerance), voxel_(voxel) {}
  /// Adapts the tolerance. `pixel`: render::FrameStats::pixel, m; 0: unknown. True: the tolerance has changed.
  bool follow(double pixel, const render::Quality& quality);
  float tolerance() const { return tolerance_; }  // the tolerance of the mesh, voxels

 private:
  float tolerance_;
  double voxel_;  // m, voxel size of the tissue
};

}  // namespace typodont
