// Computes the edge length of a patch (the field around a tool), and the distance that a tool may move inside it.
#include <algorithm>
#include <cmath>

#include "haptics/contact/proxy/smooth_contacts.h"
#include "haptics/surface_patch.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace {

double travel_for(const Tool& tool, double voxel) {
  return std::max({8.0, 1e-3 / voxel, 0.25 * tool.reach() / voxel});
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
  return 2 * static_cast<int>(std::ceil(half)) + 1;
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
    patch.wide.emplace_back();
    patch.wide.front().resize(coarse.edge);
    patch.wide.front().every = coarse.every;
  }
  return patch;
}

}  // namespace typodont::haptics
