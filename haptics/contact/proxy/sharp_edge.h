// Edges, corners, grooves and inner corners that are sharper than the samples can represent. They are constructed
// from the faces that meet at the edge or corner.
#pragma once

#include "haptics/surface_patch.h"

namespace typodont::haptics {

/// A field interpolated from samples rounds every edge within three voxels. Beyond that distance, the adjacent faces
/// are correct. This function takes the planes of these faces and computes the point of the enclosed solid that is
/// nearest to `c`. `foot`: estimate of that point, `distance`: the field at c; all in voxels. Returns false if the
/// faces are not found, enclose no convex solid, or contradict the field.
bool nearest_on_edge(const SurfacePatch& patch, const dvec3& c, const dvec3& foot, double distance,
                     dvec3& nearest) noexcept;

/// The flat walls of a groove or inner corner, each as its unit normal and the height of `c` above it.
struct FlatWalls {
  static constexpr int kMost = 3;
  int count = 0;
  dvec3 n[kMost];
  double height[kMost];
};

/// The walls of a concave crease or corner, which interpolation fills. The planes of the walls are measured beyond
/// the filled part. `at`: the field at c. Returns false if the walls are not found or another surface is nearer.
bool walls_of_crease(const SurfacePatch& patch, const dvec3& c, const FieldSample& at, FlatWalls& walls) noexcept;

}  // namespace typodont::haptics
