// Voxels of an implant tool, and eq. 2 of Zhao 2020 over them.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/units.h"
#include "haptics/tool.h"

namespace typodont::haptics::implant {

/// Centre within half a layer of the surface. T.
struct ToolVoxel {
  glm::vec3 p;      // m, centre of the voxel
  glm::vec3 n;      // unit normal, pointing out of the head
  float outside;    // m, of p from the surface, negative inside
  float area;       // m², surface area that the voxel represents
  float inverse_r;  // 1/m, mean of 1/r from the axis
  float ability;    // 0..1; 0: cannot cut
};

/// Zhao 2020's inner voxels only remove tissue, which haptics/sweep.h does.
struct ToolVoxels {
  std::vector<ToolVoxel> outer;  // the end's first
  // before the end and outside the head: they touch first
  std::size_t ahead = 0;
  double edge = 0;  // m, edge length of a voxel
  // of the end's area, by the first `ahead`; the rest is inside
  double ahead_fraction = 1;
};

/// `edge`: m; `layers`: voxels. Of a thread only the core: it moves in its groove. ToolVoxel::ability from "implant" in
/// the tool's file, else 1.
ToolVoxels make_tool_voxels(const Tool& tool, double edge, int layers);

/// On the tool / feed speed; T, about its origin.
struct CuttingWrench {
  dvec3 force{0};   // N·s/m, force per feed speed
  dvec3 torque{0};  // N·s, torque per feed speed
};

/// One voxel in eq. (2) of Zhao 2020. `u`: J/m³; `along`: unit feed, T; `speed`: rad/s about z; `alpha`: tangential /
/// normal. Nothing if it does not face the feed.
inline void add_cutting(const ToolVoxel& voxel, double u, const dvec3& along, double speed, double alpha,
                        CuttingWrench& sum) noexcept {
  const dvec3 n(voxel.n), p(voxel.p);
  const double facing = glm::dot(n, along);
  if (!(facing > 0)) return;
  // N is revolutions per second: 1/(2 pi N) is 1/speed.
  const double size =
      u * facing * static_cast<double>(voxel.area) * static_cast<double>(voxel.inverse_r) / std::abs(speed);
  // Against the edges' motion.
  const double r = std::hypot(p.x, p.y), turn = speed < 0 ? 1 : -1;
  const dvec3 tangent = r > 0 ? turn * dvec3(-p.y / r, p.x / r, 0) : dvec3(0);
  const dvec3 force = size * (tangent - n / alpha);
  sum.force += force;
  // p may be half a layer off: the lever arm is 1/inverse_r.
  sum.torque += glm::cross(p, -size / alpha * n);
  sum.torque.z += size * turn / static_cast<double>(voxel.inverse_r);
}

}  // namespace typodont::haptics::implant
