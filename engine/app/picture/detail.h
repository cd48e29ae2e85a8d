// Level of detail of the tooth's mesh. The tolerance of the mesh is adapted to the size of a pixel at the tissue,
// because details smaller than a pixel need not be meshed.
#pragma once

#include "engine/display/display_rig.h"
#include "engine/render/quality.h"

namespace typodont {

/// Returns the width (m) of a pixel of an eye's picture on this display rig's screen.
double screen_pixel(const display::DisplayRig& rig);

/// Returns the tolerance (voxels) of the tooth's mesh if a pixel has the width `pixel` (m). It is limited, so that
/// the shapes are preserved.
float surface_tolerance(double pixel, double voxel, const render::Quality& quality);
/// Returns the tolerance (voxels) of the tooth's mesh, computed from the pixels of this display rig's screen. It is
/// used before the first picture.
float surface_tolerance(const display::DisplayRig& rig, double voxel,
                        const render::Quality& quality = render::kQualityLadder.front());

/// Adapts the tolerance to the pixel size after each frame. The tolerance changes in steps, so that a small motion of
/// the user's head changes nothing. Render thread only.
class Detail {
 public:
  Detail(float tolerance, double voxel) : tolerance_(tolerance), voxel_(voxel) {}
  /// `pixel`: m, value of render::FrameStats::pixel; 0 if it is unknown. Returns true if the tolerance changed.
  bool follow(double pixel, const render::Quality& quality);
  float tolerance() const { return tolerance_; }  // returns the tolerance of the mesh, voxels

 private:
  float tolerance_;
  double voxel_;  // m, voxel size of the tissue
};

}  // namespace typodont
