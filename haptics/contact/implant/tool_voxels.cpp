#include "haptics/contact/implant/tool_voxels.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/base/voxels.h"
#include "haptics/tool.h"

namespace typodont::haptics::implant {

namespace {

// A tool voxel belongs to the end if the cosine between its normal and the feed direction -z is larger than this.
constexpr double kFacingEnd = 0.5;
// tool voxels; nearer to the axis than this, a mean of 1/r over the voxel is used (r: distance from the axis)
constexpr int kNear = 4;
constexpr int kParts = 8;  // number of parts of a voxel's edge in the mean of 1/r (r: distance from the axis)
constexpr double kVoxelRounding = 1e-6;  // voxels, tolerance for rounding errors
// tool voxels, depth below the surface at which a second normal is computed
constexpr double kWithin = 0.005;
// a rim is sharp if the cosine between the normals on the surface and at the depth kWithin is smaller than this
constexpr double kSmooth = 0.97;

/// Mean of 1/r (r: distance from the axis) over the voxel's cross-section.
double mean_inverse_r(double x, double y, double edge) {
  const double r = std::hypot(x, y);
  if (r > kNear * edge) return 1 / r;
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; j < kParts; ++j) {
      // kParts is even, so that no part of the voxel is centred on the axis, where 1/r is infinite.
      const double px = x + ((i + 0.5) / kParts - 0.5) * edge, py = y + ((j + 0.5) / kParts - 0.5) * edge;
      sum += 1 / std::max(std::hypot(px, py), edge / (4 * kParts));
    }
  }
  return sum / (kParts * kParts);
}

double ability_of(const Tool& tool, const dvec3& p, const dvec3& n) {
  if (!tool.implant) return tool.cuts ? 1 : 0;
  const ImplantTool& implant = *tool.implant;
  if (-n.z < kFacingEnd && implant.kind != ImplantToolKind::kRound) return implant.side_ability;
  return std::hypot(p.x, p.y) < implant.centre_radius ? implant.centre_ability : implant.end_ability;
}

}  // namespace

ToolVoxels make_tool_voxels(const Tool& whole, double edge) {
  Tool tool = whole;
  if (tool.implant && tool.implant->threaded()) tool.diameter = tool.implant->core_diameter;
  const HeadField head(tool, 1.0);
  const double half_layer = edge / 2, reach = tool.radius() + half_layer;
  const int across = static_cast<int>(std::ceil(reach / edge)),
            above = static_cast<int>(std::ceil(2 * tool.half() / edge)) + 1;
  ToolVoxels voxels;
  voxels.edge = edge;
  std::vector<ToolVoxel> others;
  for_each_voxel_between({-across, -across, -1}, {across, across, above}, [&](int x, int y, int z) {
    // Layers of tool voxels along the axis; a flat end lies half-way between two layers.
    const dvec3 p(edge * x, edge * y, -tool.half() + edge * (z + 0.5));
    dvec3 n;
    const double outside = head.distance(p, n);
    if (!(outside > -half_layer + kVoxelRounding * edge && outside <= half_layer + kVoxelRounding * edge)) return;
    // The head's upper end gets no voxels, because it touches bone only if the shank touches bone too.
    if (n.z > kFacingEnd && tool.shape != HeadShape::kSphere) return;
    const dvec3 on_surface = p - outside * n;
    // Voxels nearest to a sharp rim are skipped, because they represent no area.
    dvec3 n_within;
    head.distance(on_surface - kWithin * edge * n, n_within);
    if (glm::dot(n, n_within) < kSmooth) return;
    ToolVoxel voxel;
    voxel.p = glm::vec3(p);
    voxel.n = glm::vec3(n);
    voxel.outside = static_cast<float>(outside);
    voxel.area = static_cast<float>(edge * edge);
    voxel.inverse_r = static_cast<float>(mean_inverse_r(on_surface.x, on_surface.y, edge));
    voxel.ability = static_cast<float>(ability_of(whole, on_surface, n));
    (-n.z > kFacingEnd ? voxels.outer : others).push_back(voxel);
  });
  voxels.ahead = voxels.outer.size();
  voxels.outer.insert(voxels.outer.end(), others.begin(), others.end());
  return voxels;
}

}  // namespace typodont::haptics::implant
