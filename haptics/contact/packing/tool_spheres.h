// A tool of the packing method: its head as spheres. Set-up time.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/solid.h"
#include "haptics/tool.h"

namespace typodont::haptics::packing {

/// A tool as spheres. Frame T (origin at the head's centre, z along the shank), metres.
struct ToolSpheres {
  ToolSpheres() = default;
  /// Makes a head of these spheres, without non-cutting parts.
  ToolSpheres(std::vector<dvec3> centers_T, std::vector<double> radii);
  /// Adds a sphere that touches but never cuts.
  void add_non_cutting(const dvec3& p_T, double r);

  std::vector<dvec3> center_T;
  std::vector<double> radius;
  // number of head spheres, which come first; the following spheres belong to the shank and the safe end
  std::size_t head = 0;
  dvec3 com_T{0};         // m, the head's centre of mass by eq. 9, for uniform density
  double reach = 0;       // m, distance from T's origin to the farthest point of all spheres
  double head_reach = 0;  // m, distance from T's origin to the farthest point of the head's spheres

  std::size_t size() const { return radius.size(); }
};

/// Arrangement of the spheres of a head that is not a ball.
enum class HeadSpheres {
  kPacked,  // spheres of several sizes that do not overlap; force laws before version 7
  kRings,   // overlapping spheres in rings around the axis
};

/// A tool with a head of the tool table. A ball is one sphere; every other head has about `spheres` spheres. `seed`:
/// only for kPacked. Shank and safe end are chains of inscribed spheres on the tool's axis.
ToolSpheres tool_spheres(const Tool& tool, std::size_t spheres, std::uint64_t seed,
                         HeadSpheres kind = HeadSpheres::kRings);
/// Packs a closed solid in the tool's frame T with spheres, e.g. a mesh (read_mesh_solid). Throws Error if the solid is
/// unbounded.
ToolSpheres tool_spheres(const Solid& solid_T, std::size_t spheres, std::uint64_t seed);

}  // namespace typodont::haptics::packing
