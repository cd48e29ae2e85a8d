// Voxel model of an implant tool, and the cutting law summed over its voxels (Zhao 2020, eq. 2).
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"
#include "haptics/tool.h"

namespace typodont::haptics::implant {

/// A voxel of the tool's outer layer: its centre is within half a layer thickness of the head's surface. Positions and
/// normals are in the tool's frame T.
struct ToolVoxel {
  glm::vec3 p;      // m, centre of the voxel
  glm::vec3 n;      // unit normal, pointing out of the head
  float outside;    // m, signed distance of p from the head's surface, negative inside
  float area;       // m², surface area that the voxel represents
  float inverse_r;  // 1/m, mean of 1/r over the voxel, where r is the distance from the tool's axis
  float ability;    // ability to drill, 0..1; 0: the voxel cannot cut bone
};

/// The outer layer of the tool's voxels. Zhao 2020 also stores inner voxels, which only remove tissue. They are not
/// needed here, because the sweep of the head removes the tissue (haptics/sweep.h).
struct ToolVoxels {
  std::vector<ToolVoxel> outer;  // all voxels of the outer layer; those in front of the tool's end come first
  // number of voxels that lie in front of the head's end and outside the head; they touch bone when the tool advances
  std::size_t ahead = 0;
  double edge = 0;  // m, edge length of a voxel
  // fraction of the end's area that the first `ahead` voxels represent; the other voxels of the end lie inside the head
  double ahead_fraction = 1;
};

/// Converts a tool to voxels. `edge`: edge length of a voxel (m); `layers`: thickness of the outer layer in voxels. For
/// a threaded tool only its core is converted, because the thread moves in the groove that it has cut. The voxels'
/// abilities to drill (ToolVoxel::ability) come from the block `implant` in the tool's file; without this block they
/// are all 1.
ToolVoxels make_tool_voxels(const Tool& tool, double edge, int layers);

/// Force and torque of the tissue on the tool, divided by the feed speed. Both are in the tool's frame T; the torque is
/// about the origin of T.
struct CuttingWrench {
  dvec3 force{0};   // N·s/m, force per feed speed
  dvec3 torque{0};  // N·s, torque per feed speed
};

/// Adds the contribution of one voxel to eq. (2) of Zhao 2020. `u`: specific cutting energy (J/m³); `along`: unit
/// vector of the feed in the tool's frame T; `speed`: speed of the spindle (rad/s) about T's z axis; `alpha`: ratio of
/// tangential to normal force. Adds nothing if the voxel does not face the feed.
inline void add_cutting(const ToolVoxel& voxel, double u, const dvec3& along, double speed, double alpha,
                        CuttingWrench& sum) noexcept {
  const dvec3 n(voxel.n), p(voxel.p);
  const double facing = glm::dot(n, along);
  if (!(facing > 0)) return;
  // In eq. (2) of Zhao 2020, N is the number of revolutions per second. So the equation's factor 1/(2 pi N) is equal to
  // 1/speed.
  const double size =
      u * facing * static_cast<double>(voxel.area) * static_cast<double>(voxel.inverse_r) / std::abs(speed);
  // The tissue's force opposes the motion of the tool's cutting edges.
  const double r = std::hypot(p.x, p.y), turn = speed < 0 ? 1 : -1;
  const dvec3 tangent = r > 0 ? turn * dvec3(-p.y / r, p.x / r, 0) : dvec3(0);
  const dvec3 force = size * (tangent - n / alpha);
  sum.force += force;
  // p may be up to half a layer away from the head's surface. So the torque about the axis is not computed from p, but
  // from the exact lever arm 1/inverse_r.
  sum.torque += glm::cross(p, -size / alpha * n);
  sum.torque.z += size * turn / static_cast<double>(voxel.inverse_r);
}

}  // namespace typodont::haptics::implant
