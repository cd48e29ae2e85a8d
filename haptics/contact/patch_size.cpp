// Computes the edge length of a patch (the field around a tool), and the distance that a tool may move inside it.
#include <algorithm>
#include <cmath>

#include "haptics/contact/proxy/non_cutting_contacts.h"
#include "haptics/surface_patch.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

/// Returns the distance in voxels that a tool may move from the centre of its patch (copy of the field). It is at least
/// 0.4 mm. The position of a patch is a multiple of eight voxels, so half of the distance must exceed four voxels. An
/// instrument that fills may move 1 mm, because it looks in its patch for places to fill.
double travel_for(const Tool& tool, double voxel) {
  const double least = tool.fill != Tissue::kAir ? 1e-3 : 0.4e-3;
  return std::max({9.0, least / voxel, 0.25 * tool.reach() / voxel});
}

}  // namespace

int patch_edge_for(std::span<const Tool> tools, double voxel) {
  double half = 0;
  for (const Tool& tool : tools) {
    // A portion of filling grows beyond the end of the head. It can be added only if it lies completely inside the
    // patch (copy of the field), so the reach includes it.
    const double reach = std::max(near_reach(tool), tool.fill == Tissue::kAir ? 0.0 : tool.half() + tool.fill_reach);
    half = std::max(half, reach / voxel + Sweep::kMargin + 3 + travel_for(tool, voxel));
  }
  // The difference 1e-6 prevents that a rounding error adds eight samples.
  constexpr int n = Sweep::kLeaf;
  return n * static_cast<int>(std::ceil((2 * half + 1 - 1e-6) / n));
}

double patch_travel_for(std::span<const Tool> tools, double voxel) {
  double travel = 1e300;
  for (const Tool& tool : tools) travel = std::min(travel, travel_for(tool, voxel));
  return travel;
}

SurfacePatch empty_patch_for(std::span<const Tool> tools, double voxel) {
  SurfacePatch patch;
  patch.resize(patch_edge_for(tools, voxel));
  const CoarseGrid coarse = coarse_grid_for(tools, voxel, patch_travel_for(tools, voxel) * voxel / voxel);
  if (coarse.edge > 0) {
    patch.coarse_levels.emplace_back();
    patch.coarse_levels.front().resize(coarse.edge);
    patch.coarse_levels.front().every = coarse.every;
  }
  return patch;
}

}  // namespace typodont::haptics
