// Models a tool by spheres, for the contact model "packing". Called only during set-up.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/solid.h"
#include "haptics/tool.h"

namespace typodont::haptics::packing {

/// A tool as spheres. Lengths in metres, positions in the tool's frame T (origin at the head's centre, z along the
/// shank).
struct ToolSpheres {
  ToolSpheres() = default;
  /// Creates a head from the given spheres, without non-cutting parts.
  ToolSpheres(std::vector<dvec3> centers_T, std::vector<double> radii);
  /// Adds a sphere that has contact with tissue but never cuts.
  void add_non_cutting(const dvec3& p_T, double r);

  std::vector<dvec3> center_T;
  std::vector<double> radius;
  // Number of spheres of the head; they are the first spheres in the list. The remaining spheres belong to the shank
  // and the safe end (a non-cutting pin at the tip).
  std::size_t head = 0;
  dvec3 com_T{0};         // m, the head's centre of mass (paper S2, eq. 9) for uniform density
  double reach = 0;       // m, distance from the origin of the tool's frame T to the farthest point of any sphere
  double head_reach = 0;  // m, distance from the origin of the tool's frame T to the farthest point of the head

  std::size_t size() const { return radius.size(); }
};

/// Returns a tool with a head from the tool table. A head that is a ball becomes one sphere; any other head becomes at
/// most `spheres` overlapping spheres in rings around its axis. The shank and the safe end (non-cutting pin at the tip)
/// become chains of inscribed spheres on the tool's axis.
ToolSpheres tool_spheres(const Tool& tool, std::size_t spheres);
/// Packs a closed solid with spheres, for example a mesh (read_mesh_solid). The solid is in the tool's frame T. Throws
/// Error if it is unbounded.
ToolSpheres tool_spheres(const Solid& solid_T, std::size_t spheres, std::uint64_t seed);

}  // namespace typodont::haptics::packing
