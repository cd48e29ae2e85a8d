// Level of detail: how fine surfaces are made follows the pixels that show them. What a coarse picture cannot show is
// not made; what comes nearer, or is drawn larger, is made finer.
#pragma once

#include "engine/display/display_rig.h"
#include "engine/render/quality.h"

namespace typodont {

/// m: what a pixel of an eye's picture covers on the plane of this rig's screen.
double screen_pixel(const display::DisplayRig& rig);

/// How far triangles may lie from the surface, voxels, where a pixel covers so much of it (m), but never so far that
/// form is lost.
float surface_tolerance(double pixel, double voxel, const render::Quality& quality);
/// The same on the plane of this rig's screen: before anything is drawn.
float surface_tolerance(const display::DisplayRig& rig, double voxel,
                        const render::Quality& quality = render::kQualityLadder.front());

/// Follows the pixels frame by frame, in steps, so that a head that sways changes nothing. Drawing thread.
class Detail {
 public:
  Detail(float tolerance, double voxel) : tolerance_(tolerance), voxel_(voxel) {}
  /// `pixel`: render::FrameStats::pixel, 0 where nothing is known. True when the tolerance changed.
  bool follow(double pixel, const render::Quality& quality);
  float tolerance() const { return tolerance_; }  // voxels

 private:
  float tolerance_;
  double voxel_;  // m
};

}  // namespace typodont
