// Where the tissue has an edge, corner, groove or inner corner, sharper than samples can show: found from the faces
// that meet there.
#pragma once

#include "haptics/surface_patch.h"

namespace typodont::haptics {

/// A field interpolated from samples rounds every edge, within three voxels of it and of where its round part begins.
/// The faces beside it are true again a stencil farther on: this takes their planes from there and the point of the
/// solid between them that is nearest to `c`. `foot`: about where that should be, `distance`: what the field says at c,
/// all in voxels. False where the faces are not found, enclose no convex solid, or contradict the field.
bool nearest_on_edge(const SurfacePatch& patch, const dvec3& c, const dvec3& foot, double distance,
                     dvec3& nearest) noexcept;

/// The flat walls of a groove or inner corner, each by its unit normal and height of `c` over it.
struct FlatWalls {
  static constexpr int kMost = 3;
  int count = 0;
  dvec3 n[kMost];
  double height[kMost];
};

/// The same of a concave crease or corner between flat walls, which interpolation fills by as much: the walls as they
/// are a stencil away from it. `at`: the field at c. False where these are not found, or something else is nearer.
bool walls_of_crease(const SurfacePatch& patch, const dvec3& c, const FieldSample& at, FlatWalls& walls) noexcept;

}  // namespace typodont::haptics
