// A tool of an implant set as voxels, and the cutting law summed over them (Zhao 2020, eq. 2).
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"
#include "haptics/tool.h"

namespace typodont::haptics::implant {

/// A voxel of the tool's outer layer: its centre is within half a layer thickness of the head's surface. Frame T.
struct ToolVoxel {
  glm::vec3 p;      // m
  glm::vec3 n;      // unit normal, pointing out of the head
  float outside;    // m, signed distance of p from the head's surface, negative inside
  float area;       // m², surface area that the voxel represents
  float inverse_r;  // 1/m, mean of 1/r over the voxel, where r is the distance from the tool's axis
  float ability;    // 0..1, ability to drill; 0: the voxel cannot cut bone
};

/// The outer layer. The voxels inside it (inner voxels) only remove tissue; their union is the sweep of the head
/// (haptics/sweep.h), so they are not stored.
struct ToolVoxels {
  std::vector<ToolVoxel> outer;  // voxels ahead of the tool's end come first
  // number of voxels in front of the head's end and outside the head; they touch bone when the tool advances
  std::size_t ahead = 0;
  double edge = 0;  // m, size of a voxel
  // fraction of the end's area that the voxels ahead represent; the other voxels of the end lie inside the head
  double ahead_share = 1;
};

/// Converts the tool to voxels with the edge length `edge` (m) and an outer layer of `layers` voxels. For a threaded
/// tool only the core is used, because the thread runs in the groove that it has cut. The abilities come from the
/// block `implant` in the tool's file; without this block all abilities are 1.
ToolVoxels make_tool_voxels(const Tool& tool, double edge, int layers);

/// Force and torque of the tissue on the tool per m/s of feed. Frame T, about T's origin.
struct CuttingWrench {
  dvec3 force{0};   // N·s/m
  dvec3 torque{0};  // N·s
};

/// Contribution of one voxel to eq. (2): u is the specific cutting energy (J/m³), `along` the unit feed direction in
/// T, `speed` the spindle's speed (rad/s, about T's z), `alpha` the ratio of tangential to normal force. Zero if the
/// voxel does not face the feed.
inline void add_cutting(const ToolVoxel& voxel, double u, const dvec3& along, double speed, double alpha,
                        CuttingWrench& sum) noexcept {
  const dvec3 n(voxel.n), p(voxel.p);
  const double facing = glm::dot(n, along);
  if (!(facing > 0)) return;
  // 1/(2 pi N) equals 1/speed.
  const double size =
      u * facing * static_cast<double>(voxel.area) * static_cast<double>(voxel.inverse_r) / std::abs(speed);
  // The tissue's force opposes the motion of the teeth.
  const double r = std::hypot(p.x, p.y), turn = speed < 0 ? 1 : -1;
  const dvec3 tangent = r > 0 ? turn * dvec3(-p.y / r, p.x / r, 0) : dvec3(0);
  const dvec3 force = size * (tangent - n / alpha);
  sum.force += force;
  // p is at most half a layer away from the head's surface. The lever arm about the axis is exactly 1/inverse_r.
  sum.torque += glm::cross(p, -size / alpha * n);
  sum.torque.z += size * turn / static_cast<double>(voxel.inverse_r);
}

}  // namespace typodont::haptics::implant
