// A tool of an implant set as voxels, and the cutting law summed over them (Zhao 2020, eq. 2).
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"
#include "haptics/tool.h"

namespace typodont::haptics::implant {

/// A voxel of the tool's outer layer: its centre lies within half a layer of the head's surface. Frame T.
struct ToolVoxel {
  glm::vec3 p;      // m
  glm::vec3 n;      // unit, out of the head
  float outside;    // m from the head's surface to p, negative inside
  float area;       // m² of the surface that it stands for
  float inverse_r;  // 1/m, mean of one over the distance to the tool's axis
  float ability;    // 0..1, of drilling; 0: it stops at bone
};

/// The outer layer. All voxels inside it are the inner ones: they only remove, and the sweep of the head is their union
/// (haptics/sweep.h), so no list of them is kept.
struct ToolVoxels {
  std::vector<ToolVoxel> outer;  // those ahead come first
  std::size_t ahead = 0;         // so many lie outside the head before its end: what the tool meets on its way in
  double edge = 0;               // m, of a voxel
  double ahead_share = 1;        // part of the end's area that those ahead stand for; the rest lies inside the head
};

/// Voxels of `edge` m, the outer layer `layers` voxels thick. Of a threaded tool the core counts, for the thread is
/// carried by what it has cut. `ability`: whether the abilities of the tool's block count; without it all are 1.
ToolVoxels make_tool_voxels(const Tool& tool, double edge, int layers);

/// Force and torque of the tissue on the tool, per m/s of its feed. Frame T, about T's origin.
struct CuttingWrench {
  dvec3 force{0};   // N·s/m
  dvec3 torque{0};  // N·s
};

/// One voxel's part of eq. (2): u is the specific cutting energy (J/m³), `along` the unit direction of feed in T,
/// `speed` the spindle's (rad/s, about T's z), `alpha` the ratio of tangential to normal force. Nothing where the voxel
/// does not face the feed.
inline void add_cutting(const ToolVoxel& voxel, double u, const dvec3& along, double speed, double alpha,
                        CuttingWrench& sum) noexcept {
  const dvec3 n(voxel.n), p(voxel.p);
  const double facing = glm::dot(n, along);
  if (!(facing > 0)) return;
  // 1/(2 pi N) = 1/speed.
  const double size =
      u * facing * static_cast<double>(voxel.area) * static_cast<double>(voxel.inverse_r) / std::abs(speed);
  // The tissue holds the teeth back, against their way.
  const double r = std::hypot(p.x, p.y), turn = speed < 0 ? 1 : -1;
  const dvec3 tangent = r > 0 ? turn * dvec3(-p.y / r, p.x / r, 0) : dvec3(0);
  const dvec3 force = size * (tangent - n / alpha);
  sum.force += force;
  // p lies half a layer off the surface at most; the lever about the axis is exactly 1/inverse_r.
  sum.torque += glm::cross(p, -size / alpha * n);
  sum.torque.z += size * turn / static_cast<double>(voxel.inverse_r);
}

}  // namespace typodont::haptics::implant
