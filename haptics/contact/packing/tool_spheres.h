// A tool as spheres. Set-up only.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/solid.h"
#include "haptics/tool.h"

namespace typodont::haptics::packing {

/// m, T.
struct ToolSpheres {
  ToolSpheres() = default;
  /// Without non-cutting parts.
  ToolSpheres(std::vector<dvec3> centers_T, std::vector<double> radii);
  /// Touches, never cuts.
  void add_non_cutting(const dvec3& p_T, double r);

  std::vector<dvec3> center_T;
  std::vector<double> radius;
  // First in the list; the rest are shank and safe end.
  std::size_t head = 0;
  dvec3 com_T{0};         // m (S2, eq. 9), uniform density
  double reach = 0;       // m, T's origin to the farthest point
  double head_reach = 0;  // m, the same of the head

  std::size_t size() const { return radius.size(); }
};

/// A ball is one sphere; other heads up to `spheres` in rings; shank and safe end are chains on the axis.
ToolSpheres tool_spheres(const Tool& tool, std::size_t spheres);
/// For example a mesh (read_mesh_solid), T. Throws Error if unbounded.
ToolSpheres tool_spheres(const Solid& solid_T, std::size_t spheres, std::uint64_t seed);

}  // namespace typodont::haptics::packing
