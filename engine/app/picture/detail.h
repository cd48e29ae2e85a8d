// Level of detail: the mesh tolerance follows the size of a pixel on the tissue, so that details below a pixel are not
// meshed.
#pragma once

#include "engine/display/display_rig.h"
#include "engine/render/quality.h"

namespace typodont {

/// Size in m of a pixel of an eye's picture in the plane of this rig's screen.
double screen_pixel(const display::DisplayRig& rig);

/// Tolerance in voxels for a pixel of the given size (m), limited so that shapes are preserved.
float surface_tolerance(double pixel, double voxel, const render::Quality& quality);
/// surface_tolerance() for a pixel in the plane of this rig's screen. It is used before the first picture.
float surface_tolerance(const display::DisplayRig& rig, double voxel,
                        const render::Quality& quality = render::kQualityLadder.front());

/// Adapts the tolerance to the pixel size after each frame, in steps, so that small head motions change nothing.
/// Drawing thread.
class Detail {
 public:
  Detail(float tolerance, double voxel) : tolerance_(tolerance), voxel_(voxel) {}
  /// `pixel`: render::FrameStats::pixel, 0 if unknown. Returns true if the tolerance changed.
  bool follow(double pixel, const render::Quality& quality);
  float tolerance() const { return tolerance_; }  // voxels

 private:
  float tolerance_;
  double voxel_;  // m
};

}  // namespace typodont
