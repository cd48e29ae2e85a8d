// A head prepared for the contact search: samples of its surface and its meridian, as arrays of floats for SIMD.
#pragma once

#include "haptics/contact/proxy/contact_set.h"
#include "haptics/surface_patch.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// A piece of the head's meridian in floats; see HeadField::Piece.
struct FlatPiece {
  float ax, az, bx, bz, dx, dz, inverse2;
  float cx, cz, radius;
  float ux, uz, wx, wz;  // vectors from an arc's centre to its ends
  float nx, nz;          // outward normal of a line
};

/// Result of one search.
struct Found {
  int count;
  float deepest;
  float area, area_x, area_y, area_z;
};

/// The samples as arrays, in clusters of eight neighbours, which mostly touch the same tissue. Built at set-up, in
/// voxels; the functions are servo-safe.
struct HeadSamples {
  HeadSamples(const Tool& tool, const HeadField& head, double voxel);

  /// Searches contacts of the head at X_VT. Each sample near tissue is moved to the point where head and surface are
  /// closest; it is kept if the gap there is below `near`.
  Found look_around(const SurfacePatch& patch, const Pose& X_VT, float near, RoughPlanes& planes) const noexcept;

  /// Updates normals and gaps of known points. The head has the rotation R and has moved by `moved` since the search.
  /// Returns the deepest overlap.
  float update_planes(const dquat& R, const glm::vec3& moved, RoughPlanes& planes, int count) const noexcept;

  /// Moves points that lie in the head to its surface. The head's centre is at `c`, relative to the points' origin;
  /// contacts that the head still touches get gap 0.
  void push_out_at(const dquat& R, const glm::vec3& c, RoughPlanes& planes, int count) const noexcept;
  /// Same as push_out_at(), for a head that has not moved since the search.
  void push_out_here(RoughPlanes& planes, int count) const noexcept;

  alignas(32) float px[ContactSet::kMax], py[ContactSet::kMax], pz[ContactSet::kMax];
  alignas(32) float nx[ContactSet::kMax], ny[ContactSet::kMax], nz[ContactSet::kMax], area[ContactSet::kMax];
  FlatPiece pieces[HeadField::kMaxPieces];
  int piece_count;
  float ball_radius;  // radius of a ball; otherwise 0
  float thickness;    // half the head's width
  float reach;        // distance of the farthest point from the centre
};

}  // namespace typodont::haptics
