// A tool of the packing method: its head as spheres. Set-up time.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/solid.h"
#include "haptics/tool.h"

namespace typodont::haptics::packing {

/// Frame T (head centre, z along the shank), metres.
struct ToolSpheres {
  std::vector<dvec3> center_T;
  std::vector<double> radius;
  dvec3 com_T{0};    // centre of mass by eq. 9, of even density
  double reach = 0;  // m, from T's origin to the farthest point of any sphere
};

/// A head of the tool table: a ball is one sphere, every other head is packed with `spheres` of them.
ToolSpheres tool_spheres(const Tool& tool, std::size_t spheres, std::uint64_t seed);
/// A closed solid given in T, e.g. a mesh (read_mesh_solid). Throws Error where it has no bounds.
ToolSpheres tool_spheres(const Solid& solid_T, std::size_t spheres, std::uint64_t seed);

}  // namespace typodont::haptics::packing
