// A head as contacts are looked for with it: samples of its surface and its meridian, in floats, eight side by side.
#pragma once

#include "haptics/contact/proxy/contact_set.h"
#include "haptics/surface_patch.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A piece of the head's meridian in floats; see HeadField::Piece.
struct FlatPiece {
  float ax, az, bx, bz, dx, dz, inverse2;
  float cx, cz, radius;
  float ux, uz, wx, wz;  // from an arc's centre to its ends
  float nx, nz;          // outward normal of a line
};

/// What a look around has found.
struct Found {
  int count;
  float deepest;
  float area, area_x, area_y, area_z;
};

/// The samples side by side, in clusters of eight neighbours: what one of a batch is near to, most of it are. Built at
/// set-up, in voxels; the rest is servo-safe.
struct HeadSamples {
  HeadSamples(const Tool& tool, const HeadField& head, double voxel);

  /// Looks around with the head at X_VT: those that are near tissue are slid to where head and surface are closest, and
  /// kept if the gap there is below `near`.
  Found look_around(const SurfacePatch& patch, const Pose& X_VT, float near, RoughPlanes& planes) const noexcept;

  /// New normals and gaps of known points for the head turned by R, `moved` since they were found. The deepest overlap.
  float look_again(const dquat& R, const glm::vec3& moved, RoughPlanes& planes, int count) const noexcept;

  /// Points that lie in the head come out of it, and touch it if it is still there: at `c`, from where they are
  /// counted.
  void come_out(const dquat& R, const glm::vec3& c, RoughPlanes& planes, int count) const noexcept;
  /// The same where the head is where it looked around.
  void come_out_here(RoughPlanes& planes, int count) const noexcept;

  alignas(32) float px[ContactSet::kMax], py[ContactSet::kMax], pz[ContactSet::kMax];
  alignas(32) float nx[ContactSet::kMax], ny[ContactSet::kMax], nz[ContactSet::kMax], area[ContactSet::kMax];
  FlatPiece pieces[HeadField::kMaxPieces];
  int piece_count;
  float ball_radius;  // of a ball; else 0
  float thickness;    // half its width
  float reach;        // the farthest point from the centre
};

}  // namespace typodont::haptics
