// The voxels of an implant tool, and the cutting law (Zhao 2020, eq. 2) for one of them.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"
#include "haptics/tool.h"

namespace typodont::haptics::implant {

/// A tool voxel. Its centre is within half a layer of the tool's surface. Frame T.
struct ToolVoxel {
  glm::vec3 p;      // m, centre of the voxel
  glm::vec3 n;      // unit normal, pointing out of the head
  float outside;    // m, signed distance of p from the surface, negative inside
  float area;       // m², surface area that the voxel represents
  float inverse_r;  // 1/m, mean of 1/r over the voxel; r: distance from the axis
  float ability;    // cutting ability 0..1; 0: cannot cut
};

/// All voxels of a tool, one layer. The inner voxels of Zhao 2020 are not needed: haptics/sweep.h removes tissue, and a
/// tool voxel touches bone up to a bone voxel away.
struct ToolVoxels {
  std::vector<ToolVoxel> outer;  // the voxels of the tool's end come first
  std::size_t ahead = 0;         // number of voxels of the tool's end
  double edge = 0;               // m, edge length of a voxel
};

/// Makes the voxels of a tool. `edge`: m. A threaded tool has only voxels of its core, because the thread moves in its
/// groove. Cutting ability: from "implant" in the tool's file, otherwise 1.
ToolVoxels make_tool_voxels(const Tool& tool, double edge);

/// Force and torque on the tool, divided by the feed speed, in frame T about its origin.
struct CuttingWrench {
  dvec3 force{0};   // N·s/m, force per feed speed
  dvec3 torque{0};  // N·s, torque per feed speed
};

/// Adds force and torque on one voxel (Zhao 2020, eq. 2) to `sum`, if the voxel faces the feed. `u`: specific energy,
/// J/m³; `along`: unit vector of the feed, frame T; `speed`: rad/s about z; `alpha`: tangential / normal force.
inline void add_cutting(const ToolVoxel& voxel, double u, const dvec3& along, double speed, double alpha,
                        CuttingWrench& sum) noexcept {
  const dvec3 n(voxel.n), p(voxel.p);
  const double facing = glm::dot(n, along);
  if (!(facing > 0)) return;
  // The paper's N is in revolutions per second, so the paper's 1/(2 pi N) is 1/speed here.
  const double size =
      u * facing * static_cast<double>(voxel.area) * static_cast<double>(voxel.inverse_r) / std::abs(speed);
  // The tangential force acts against the motion of the edges.
  const double r = std::hypot(p.x, p.y), turn = speed < 0 ? 1 : -1;
  const dvec3 tangent = r > 0 ? turn * dvec3(-p.y / r, p.x / r, 0) : dvec3(0);
  const dvec3 force = size * (tangent - n / alpha);
  sum.force += force;
  // The tangential force's lever arm is 1/inverse_r, not r, because the centre p may lie beside the tool's surface.
  sum.torque += glm::cross(p, -size / alpha * n);
  sum.torque.z += size * turn / static_cast<double>(voxel.inverse_r);
}

}  // namespace typodont::haptics::implant
