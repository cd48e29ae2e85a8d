// Data of a head for the contact search: samples of its surface, and its meridian. Both are arrays of floats for SIMD.
#pragma once

#include <vector>

#include "haptics/contact/proxy/contact_set.h"
#include "haptics/contact/tissue_patch.h"
#include "haptics/cutting/meridian.h"
#include "haptics/tool.h"

namespace typodont::haptics {

/// Result of one contact search. `count`: number of contacts. `deepest`: voxels, largest overlap. `area`: contact area,
/// voxels². `area_x`, `area_y`, `area_z`: sum of area times outward normal of the tissue, voxels².
struct Found {
  int count;
  float deepest;
  float area, area_x, area_y, area_z;
};

/// Samples of the head's surface as arrays, in voxels, in the head's frame T. Eight neighbouring samples form a batch,
/// so a batch usually touches only one tissue. Built at set-up; the functions may be called on the servo thread.
struct HeadSamples {
  HeadSamples(const Tool& tool, const HeadField& head, double voxel);

  /// Searches contacts of the head at the pose X_VT. Each sample near tissue gives a point that is moved to the
  /// position where head and tissue are closest. This point becomes a contact if the gap is below `near` (voxels).
  Found search_around(const TissuePatch& patch, const Pose& X_VT, float near, ApproximatePlanes& planes) const noexcept;

  /// Updates the normals and gaps of the contacts of the last search. `R`: current rotation of the head; `moved`:
  /// displacement of the head since the search, voxels. Returns the largest overlap in voxels.
  float update_planes(const dquat& R, const glm::vec3& moved, ApproximatePlanes& planes, int count) const noexcept;

  /// Moves surface points that are inside the head to the head's surface. `c`: the head's centre, relative to the
  /// origin of the points. The gap of these contacts becomes 0.
  void push_out_at(const dquat& R, const glm::vec3& c, ApproximatePlanes& planes, int count) const noexcept;
  /// Moves surface points that are inside the head to the head's surface, as push_out_at() does, for a head that has
  /// not moved since the search.
  void push_out_here(ApproximatePlanes& planes, int count) const noexcept;

  alignas(32) float px[ContactSet::kMax], py[ContactSet::kMax], pz[ContactSet::kMax];
  alignas(32) float nx[ContactSet::kMax], ny[ContactSet::kMax], nz[ContactSet::kMax], area[ContactSet::kMax];
  MeridianPiece pieces[HeadField::kMaxPieces];
  int piece_count;
  float ball_radius;  // voxels, radius of a ball; 0 for any other head
  float thickness;    // voxels, largest radius of the head
  float reach;        // voxels, distance from the head's centre to its farthest point
  // Points such that every point of the head's surface is nearer than cover_radius (voxels) to one of them. Empty if
  // the samples themselves are so dense that no tissue fits between them.
  std::vector<glm::vec3> cover;
  float cover_radius = 0;
};

}  // namespace typodont::haptics
