// A tool that consists of spheres. Set-up only. S2: see docs/papers.md.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/solid.h"
#include "haptics/tool.h"

namespace typodont::haptics::packing {

/// Spheres of a tool: m, in frame T.
struct ToolSpheres {
  ToolSpheres() = default;
  /// The spheres of a head, without non-cutting parts.
  ToolSpheres(std::vector<dvec3> centers_T, std::vector<double> radii);
  /// Adds a sphere that touches but never cuts.
  void add_non_cutting(const dvec3& p_T, double r);

  std::vector<dvec3> center_T;
  std::vector<double> radius;
  // m, for each sphere of the head: radius of the head's surface there, for the volume of a cut. In a ring of spheres,
  // it is the distance from the axis to the surface.
  std::vector<double> curve;
  // Number of spheres of the head, which come first. The rest belong to shank and safe end.
  std::size_t head = 0;
  double reach = 0;       // m from T's origin to the tool's farthest point
  double head_reach = 0;  // m from T's origin to the head's farthest point

  std::size_t size() const { return radius.size(); }
  /// False for a single ball at T's origin, whose contacts do not depend on rotation.
  bool turns_matter() const { return size() > 1 || center_T[0] != dvec3(0); }
};

/// A ball is one sphere, any other head up to `spheres` spheres in rings. Shank and safe end: chains on the axis.
ToolSpheres tool_spheres(const Tool& tool, std::size_t spheres);
/// Spheres of a solid in frame T, for example a mesh (read_mesh_solid). Throws Error if it is unbounded.
ToolSpheres tool_spheres(const Solid& solid_T, std::size_t spheres, std::uint64_t seed);

}  // namespace typodont::haptics::packing
